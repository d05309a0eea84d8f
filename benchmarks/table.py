"""Rows of the benchmark table, and fair timing of calls against one another."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from statistics import median

NAN = float("nan")


@dataclass(frozen=True)
class Row:
    """One measured quantity; where it has a rival, `ratio` says how many times better it is."""

    benchmark: str
    quantity: str
    value: float
    unit: str
    rival: str = ""
    rival_value: float = NAN
    better: str = "lower"  # or higher
    # Of a row that a figure shows: which panel, which curve or colour, and where along the axis.
    panel: str = ""
    series: str = ""
    at: float | str = NAN

    @property
    def ratio(self) -> float:
        over, under = (
            (self.rival_value, self.value)
            if self.better == "lower"
            else (self.value, self.rival_value)
        )
        return over / under if under else NAN


def paired(
    calls: dict[str, Callable[[], object]], repeats: int = 5, warm_up: bool = True
) -> dict[str, float]:
    """Median wall seconds of each call. They take turns, so that a slow moment of the machine meets
    all of them; the first round is not counted.
    """
    seconds: dict[str, list[float]] = {name: [] for name in calls}
    for turn in range(repeats + warm_up):
        for name, call in calls.items():
            began = time.perf_counter()
            call()
            if turn >= warm_up:
                seconds[name].append(time.perf_counter() - began)
    return {name: median(values) for name, values in seconds.items()}
