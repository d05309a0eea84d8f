"""Table 3.3: reconstruction error

NMTE of the test trajectory mapped to reduced coordinates and back: the mean over time of the
error's norm, divided by the largest norm of the trajectory, over all free displacements. Median
over seeds, smallest and largest in parentheses. A failed seed counts as infinitely wrong; a
median that this makes infinite is a failure and has no number. The full-order model is the
reference and has no error.
"""

from vibrom.report import errors
from vibrom.report.columns import CASE, METHOD, OUTCOME, SEEDS

FAMILY = "models"
PLACE = 30
ASKED = "reconstruction"  # where that is asked only
COLUMNS = (CASE, METHOD, errors.NMTE, *errors.THESIS, SEEDS, OUTCOME)


def build(collection, scores):
    """One row a case and model."""
    return errors.rows("reconstruction", "test", COLUMNS, collection, scores)
