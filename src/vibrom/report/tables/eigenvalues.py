"""Table 3.2: eigenvalues of the linear dynamics

First pair of eigenvalues of each model at rest (the one with positive imaginary part): the real
part is the decay rate, the imaginary part the frequency. Median over seeds, with the smallest and
largest value in parentheses; seeds that failed are left out and counted under outcome.
"""

from vibrom.report.columns import CASE, METHOD, OUTCOME, SEEDS, Column, published
from vibrom.report.scores import endings
from vibrom.thesis import published as thesis

FAMILY = "models"
PLACE = 20
ASKED = "eigenvalues"  # where that is asked only
PARTS = ("real_per_s", "imaginary_rad_per_s")
COLUMNS = (
    CASE,
    METHOD,
    # Models differ from one another in the fourth digit.
    Column("real_per_s", "Real part [1/s]", digits=6, spread=True),
    Column("imaginary_rad_per_s", "Imaginary part [rad/s]", digits=6, spread=True),
    published("thesis_real_per_s", "Thesis real [1/s]"),
    published("thesis_imaginary_rad_per_s", "Thesis imaginary [rad/s]"),
    SEEDS,
    OUTCOME,
)


def build(collection, scores):
    """One row a case and model."""
    rows = []
    for scene, model in collection.models:
        row = {"case": scene, "method": model, "seeds": len(collection.seeds(scene, model))}
        for part in PARTS:
            row |= scores.spread(scene, model, "eigenvalues", part, worst=False).columns(part)
        row |= {
            f"thesis_{part}": value for part, value in zip(PARTS, thesis.eigenvalue(scene, model))
        }
        rows.append(row | {"outcome": endings(collection, scores, scene, model, "eigenvalues")})
    return rows
