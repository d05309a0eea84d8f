"""What the accuracy of the full order costs

One row a setting. Varied are the time step for each scheme (Newmark, generalised alpha or
energy-momentum, its numerical damping alpha, and whether the first acceleration obeys the equation
of motion or is zero), the residual at which a step has converged, and the mesh. In the thesis the
first acceleration is zero. Errors in time are NMTEs of the test decay and of the last period of a
forced run from rest, against the same mesh with a fine step, no numerical damping and a tight
residual; the row "reference" gives the estimated error of that (Richardson). Errors of meshes are
those of the first frequency and of the largest modal coordinate in the last period of a run forced
at the mesh's own first frequency, against the finest mesh, whose error is taken to be its distance
from the mesh half as fine.

Times are medians of repeated runs, without loading and compilation; the artefacts name processor,
threads and load.
"""

from vibrom.artefacts.outcome import Outcome
from vibrom.report import cost
from vibrom.report.collection import FULL_ORDER
from vibrom.report.columns import CASE, METHOD, OUTCOME, Column

FAMILY = "cost"
PLACE = 110
# question: the columns of its error and its seconds
QUESTIONS = {
    "decay": ("decay_error_percent", "decay_s"),
    "forced": ("forced_error_percent", "forced_s"),
    "frequency": ("omega_1_error_percent", "assembly_s"),
    "response": ("response_error_percent", "response_s"),
}
ABOUT = (
    Column("study", "Varied"),
    Column("element", "Element"),
    Column("columns", "Columns", whole=True),
    Column("rows", "Rows", whole=True),
    Column("free_dofs", "Free dofs", whole=True),
    Column("steps_per_period", "Steps a period", whole=True),
    Column("scheme", "Scheme"),
    Column("alpha", "Numerical damping [–]"),
    Column("initial_acceleration", "Initial acceleration"),
    Column("residual", "Residual [–]"),
)
COLUMNS = (
    CASE,
    METHOD,
    *ABOUT,
    Column("omega_1_rad_per_s", "ω1 [rad/s]"),
    Column("decay_error_percent", "Decay [%]"),
    Column("decay_s", "Decay [s]"),
    Column("forced_error_percent", "Forced run [%]"),
    Column("forced_s", "Forced run [s]"),
    Column("omega_1_error_percent", "ω1 [%]"),
    Column("assembly_s", "Assembly, modes [s]"),
    Column("response_error_percent", "Forced amplitude [%]"),
    Column("response_s", "Forced amplitude [s]"),
    OUTCOME,
)


def build(collection, scores):
    """One row a setting, and one with the estimated errors of the references."""
    rows = []
    for scene, dataset in cost.studied(collection, "cost_full_order").items():
        identity = {"case": scene, "method": FULL_ORDER}
        for index in range(dataset.sizes["setting"]):
            row = {column.name: dataset[column.name].values[index] for column in ABOUT}
            row["omega_1_rad_per_s"] = dataset["first_frequency"].values[index]
            given = cost.answers(dataset, index)
            for question, (error, seconds) in QUESTIONS.items():
                row |= {error: given[question].error, seconds: given[question].seconds}
            rows.append(identity | row | {"outcome": cost.tally(given)})
        own = {
            QUESTIONS[str(name)][0]: float(value)
            for name, value in zip(dataset["question"].values, dataset["reference_error"].values)
        }
        rows.append(identity | {"study": "reference", "outcome": Outcome.OK} | own)
    return rows + cost.missing(collection, "cost_full_order")
