"""Table 3.4: error of the predicted decay

NMTE of the free decay from the test state over the whole run, simulated in reduced coordinates
and mapped back. Beside it stands the error against the converged motion, which is free of numerical
damping, starts in balance, and is extrapolated from two time steps (``record.finer``); there the
full order at the settings of its scene has an error too, which the others have learnt. Median over
seeds, smallest and largest in parentheses; a failed seed counts as
infinitely wrong. The first failure is the earliest time at which a seed failed; leaving the range
of the training data is no failure and has a column of its own, again with the earliest time over
seeds. The thesis integrates with a relative tolerance of 1e-3, so that its numbers carry an
integration error; these do not.
"""

from vibrom.report import errors
from vibrom.report.columns import CASE, METHOD, OUTCOME, SEEDS

FAMILY = "models"
PLACE = 40
ASKED = "decay"  # where that is asked only
COLUMNS = (
    CASE,
    METHOD,
    errors.NMTE,
    *errors.THESIS,
    errors.CONVERGED,
    SEEDS,
    OUTCOME,
    *errors.TIMES,
)


def build(collection, scores):
    """One row a case and model."""
    return errors.rows("decay", "test", COLUMNS, collection, scores)
