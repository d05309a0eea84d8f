"""Table 3.5: error of the forced response

NMTE over the last period of a run forced from rest at the damped first frequency, and the error
of the probe's amplitude in that period (with its sign). Median over seeds, smallest and largest
in parentheses; for the NMTE a failed seed counts as infinitely wrong, the amplitude leaves it
out, and the outcome says how the seeds ended. "fails" is what the thesis prints.

The first failure is the earliest time at which a seed failed. A seed that only left the range of
its training data still has a value: the earliest such time has a column of its own. A seed that is
``not_steady`` has a value too, of a response that still changed by more than the scene's tolerance
(``experiments.forced.steady``) in the last quarter of its run; the .csv says by how much of the
amplitude (``change``).
"""

from vibrom.report import errors
from vibrom.report.columns import CASE, METHOD, OUTCOME, SEEDS

FAMILY = "models"
PLACE = 50
ASKED = "forced"  # where that is asked only
COLUMNS = (
    CASE,
    METHOD,
    errors.NMTE,
    *errors.THESIS,
    errors.AMPLITUDE,
    SEEDS,
    OUTCOME,
    *errors.TIMES,
    errors.CHANGE,
)


def build(collection, scores):
    """One row a case and model."""
    return errors.rows("forced", "forced", COLUMNS, collection, scores)
