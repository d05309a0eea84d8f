"""Guards: what they rescue and what they cost

The scene's own response curve, decay and forced run, with each guard of the same fitted model,
and with each integrator and no guard. Guards change the dynamics, and beyond the training range
also the decoder of polynomial models, which is extrapolated linearly there. A failed point of the
curve counts as infinitely wrong, and a curve with gaps has no peak; medians are over seeds. For
the decays from random states the table counts in how many the mechanical energy of the decoded
motion, or the largest reduced position, grew from one period to the next: the damping is
positive, so neither should. Whether a model of one oscillator may gain energy anywhere is looked at
on a fine grid of its phase plane, far beyond the training range: its least damping ratio, and by
how much its phase turns at least, of all seeds; with both positive every unforced motion comes to
rest (``vibrom.studies.parts.certificate``).
"""

import numpy as np

from vibrom.artefacts.outcome import Tally
from vibrom.report import robustness
from vibrom.report.columns import CASE, METHOD, OUTCOME, SEEDS, Column
from vibrom.report.scores import spread
from vibrom.studies.parts.grid import rises

FAMILY = "robustness"
PLACE = 320
# column: variable, and whether a failed seed is infinitely wrong
MEASURES = {
    "decay_nmte_percent": ("decay_nmte", True),
    "forced_nmte_percent": ("forced_nmte", True),
    "real_per_s": ("real_part", False),
}
COLUMNS = (
    CASE,
    METHOD,
    Column("guard", "Guard"),
    Column("integrator", "Integrator"),
    SEEDS,
    Column("points", "Points", whole=True),
    Column("points_with_value", "With a value", whole=True),
    Column("median_amplitude_error_percent", "Median amplitude error [%]", spread=True),
    Column("peak_error_percent", "Peak error [%]", spread=True),
    Column("peak_steps", "Peak off by [frequencies]", spread=True),
    Column("decay_nmte_percent", "Decay NMTE [%]", spread=True),
    Column("forced_nmte_percent", "Forced NMTE [%]", spread=True),
    Column("real_per_s", "Real part [1/s]", spread=True),
    Column("decays", "Decays", whole=True),
    Column("energy_rises", "Energy rose in", whole=True),
    Column("envelope_rises", "Amplitude rose in", whole=True),
    Column("least_damping", "Least damping ratio [–]", optional=True),
    Column("least_turning", "Least turning [–]", optional=True),
    OUTCOME,
)


def build(collection, scores):
    """One row a case, model, guard and integrator."""
    rows = []
    for group in robustness.groups(collection):
        row = {**group.identity, "seeds": len(group.answers)}
        row |= robustness.curve(collection, group)
        for column, (name, worst) in MEASURES.items():
            values = (float(answer[name]) for answer in group.answers)
            row |= spread(values, worst=worst).columns(column)
        ended = robustness.endings(group.answers, "frc_outcome")
        rows.append(row | decays(group) | certified(group) | {"outcome": Tally(ended)})
    return rows


def decays(group: robustness.Group) -> dict[str, int | None]:
    """How many decays there are, of the first integrator, and in how many something grew."""
    answers = [answer for answer in group.answers if group.first and robustness.evaluated(answer)]
    counts: dict[str, int | None] = {"decays": sum(answer.sizes["release"] for answer in answers)}
    for name in ("energy", "envelope"):
        grown = [int(rises(answer[name].values).sum()) for answer in answers]
        counts[f"{name}_rises"] = int(np.sum(grown)) if grown else None
    return counts


def certified(group: robustness.Group) -> dict[str, float]:
    """The least damping and turning of all seeds; NaN where they are not known."""
    return {
        name: float(np.fmin.reduce([found[name] for found in group.answers], initial=np.nan))
        for name in ("least_damping", "least_turning")
        if group.first and all(name in found for found in group.answers)
    }
