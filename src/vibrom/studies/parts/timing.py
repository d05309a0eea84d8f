"""What was measured of a setting: its error, and a fair time."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from statistics import median
from typing import Any, NamedTuple, TypeVar

import numpy as np

from vibrom.artefacts.outcome import Outcome
from vibrom.studies.parts.records import Column

Answer = TypeVar("Answer")
QUESTION = ("question",)


class Measured(NamedTuple):
    """Of one setting and question; as it stands, of a question that is not put to the setting."""

    outcome: Outcome = Outcome.NOT_RUN
    error: float = float("nan")  # percent
    seconds: float = float("nan")  # median
    calls: int = 0  # behind the median


def columns(error: str, seconds: str, calls: str, outcome: str) -> dict[str, Column]:
    """The variables of what was measured, with these long names."""
    return {
        "error": Column("percent", error, QUESTION),
        "seconds": Column("s", seconds, QUESTION),
        "calls": Column("1", calls, QUESTION),
        "outcome": Column("1", outcome, QUESTION, missing=Outcome.NOT_RUN),
    }


def entries(answers: Mapping[str, Measured], questions: Sequence[str]) -> dict[str, np.ndarray]:
    """The entries of a record: one of each question."""
    rows = [answers.get(question, Measured()) for question in questions]
    return {
        name: np.array([getattr(row, name) for row in rows], object if name == "outcome" else float)
        for name in Measured._fields
    }


def repeated(
    call: Callable[[], tuple[Answer, float]], repeats: int, patience: float
) -> tuple[Answer, float, int]:
    """(answer, median seconds, calls) of `call() -> (answer, seconds)`: called `repeats` times, or
    until it took `patience` seconds in all.
    """
    answer, seconds = call()
    spent: list[Any] = [seconds]
    while len(spent) < repeats and sum(spent) < patience:
        spent.append(call()[1])
    return answer, float(median(spent)), len(spent)
