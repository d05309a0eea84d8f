"""What each effect of a scene is worth: its answers with the effect left out, against all of it."""

from dataclasses import dataclass

from vibrom.config.kinds import Count


@dataclass(frozen=True)
class Ablation:
    """How long the runs are."""

    decay_periods: Count  # of the damped first mode
    forced_periods: Count  # the response is that of the last one
    timed_periods: Count  # of a decay whose time is taken
    repeats: Count  # runs of each body, of which the median is the time
