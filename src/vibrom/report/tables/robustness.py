"""Robustness tests: how many runs hold

Every model is forced from rest at each level and frequency of the grid, released from random
states up to the given distance beyond its training range, and forced from such states
(``studies.robustness`` in ``config.yaml``). A run holds when it goes all the way, inside its
training range or out of it; the interval is Wilson's for 95 % (J. Am. Stat. Assoc. 22 (1927)
209). With ``bounded`` the polynomials are extrapolated linearly beyond the training range; with
``dissipative`` the dynamics are fitted again so that they cannot gain energy anywhere.
"""

import numpy as np
from scipy.stats import binomtest

from vibrom.artefacts.outcome import Tally
from vibrom.report import robustness
from vibrom.report.columns import CASE, METHOD, OUTCOME, Column

FAMILY = "robustness"
PLACE = 310
COLUMNS = (
    CASE,
    METHOD,
    Column("guard", "Guard"),
    Column("integrator", "Integrator"),
    Column("runs", "Runs", whole=True),
    *(
        Column(ending.value, ending.value.replace("_", " ").capitalize(), whole=True)
        for ending in robustness.ENDINGS
    ),
    Column("not_asked", "Not evaluated", whole=True),
    Column("held_percent", "Held [%]"),
    Column("held_low_percent", "95 % from [%]"),
    Column("held_high_percent", "to [%]"),
    Column("median_failure_periods", "Median failure [periods]"),
    Column("largest_range_ratio", "Farthest [of the training range]"),
    OUTCOME,
)


def build(collection, scores):
    """One row a case, model, guard and integrator: all runs of the grid over all seeds."""
    rows = []
    for group in robustness.groups(collection):
        tally = Tally(robustness.endings(group.answers))
        counts = {ending.value: tally[ending] for ending in robustness.ENDINGS}
        runs = sum(counts.values())
        held = np.array([ending.has_value for ending in robustness.endings(group.answers)])
        failed_at, ranges = (
            np.concatenate([answer[name].values for answer in group.answers])
            for name in ("failed_at", "range_ratio")
        )
        share, low, high = held_share(int(held.sum()), runs)
        rows.append(
            {
                **group.identity,
                "runs": runs,
                **counts,
                "not_asked": len(held) - runs,
                "held_percent": share,
                "held_low_percent": low,
                "held_high_percent": high,
                "median_failure_periods": median(failed_at[~held]),
                "largest_range_ratio": max(ranges[held & np.isfinite(ranges)], default=np.nan),
                "outcome": tally,
            }
        )
    return rows


def held_share(held: int, runs: int) -> tuple[float, float, float]:
    """Percentage, and the ends of its interval; NaN where nothing was evaluated."""
    if runs == 0:
        return np.nan, np.nan, np.nan
    share = binomtest(held, runs)
    interval = share.proportion_ci(method="wilson")
    return 100 * share.statistic, 100 * interval.low, 100 * interval.high


def median(values: np.ndarray) -> float:
    """Of those that are finite."""
    good = values[np.isfinite(values)]
    return float(np.median(good)) if good.size else np.nan
