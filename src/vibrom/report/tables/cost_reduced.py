"""What the accuracy of the methods costs

One row a setting and seed: every model of the run as configured, then one setting after the other
varied. ``thin`` trains on every k-th sample, ``periods`` on the first k periods of the training
decay, ``start.epochs`` trains the model that a method starts from for k epochs, ``rtol`` is the
tolerance of the integrator. Errors are NMTEs of the test decay and of the last period of the
forced run, and the median amplitude error of the response curve; where there is none the cell
says how the answer ended. Varied settings are trained from one seed.

Times are medians of repeated calls, without loading and compilation; what takes long is not
repeated. Those of models as configured are those of their own training job.
"""

from functools import partial

from vibrom.report import cost
from vibrom.report.columns import CASE, METHOD, OUTCOME, Column, Row, hidden, missing, number

FAMILY = "cost"
PLACE = 120
HEADINGS = {"decay": "Decay", "forced": "Forced run", "frc": "Response curve"}


def error_or_outcome(row: Row, question: str) -> str:
    """Where there is no value the cell says why."""
    error = row[f"{question}_error_percent"]
    return number(row[f"{question}_outcome"] if missing(error) else error)


COLUMNS = (
    CASE,
    METHOD,
    Column("seed", "Seed"),
    Column("varied", "Varied"),
    Column("set_to", "Set to"),
    Column("data_s", "Training data [s]"),
    Column("mapping_s", "Mapping [s]"),
    Column("dynamics_s", "Dynamics [s]"),
    *(
        column
        for name, words in HEADINGS.items()
        for column in (
            Column(
                f"{name}_error_percent",
                f"{words} [%]",
                text=partial(error_or_outcome, question=name),
            ),
            Column(f"{name}_s", f"{words} [s]"),
            *hidden(f"{name}_outcome"),
        )
    ),
    OUTCOME,
)


def build(collection, scores):
    """One row a setting and seed."""
    rows = []
    for one in cost.settings(collection):
        row = {
            "case": one.scene,
            "method": one.method,
            "seed": "unseeded" if one.seed is None else str(one.seed),
            "varied": one.varied,
            "set_to": one.set_to,
            "data_s": one.data,
            "mapping_s": one.mapping,
            "dynamics_s": one.dynamics,
            "outcome": cost.tally(one.answers),
        }
        for name, answer in one.answers.items():
            row |= {
                f"{name}_error_percent": answer.error,
                f"{name}_s": answer.seconds,
                f"{name}_outcome": answer.outcome,
            }
        rows.append(row)
    return rows + cost.missing(collection, "cost_reduced")
