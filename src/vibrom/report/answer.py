"""What the answer is, as a table; `report.sentences` says it in words.

It has a row a method and, of each case, a column a question: the median over seeds, the
seeds' range, how they ended in words, and the thesis's number. The best median of a column is
marked.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import product

import numpy as np

from vibrom.artefacts.outcome import Outcome, Tally
from vibrom.report import branches, curves
from vibrom.report.collection import FULL_ORDER, Collection
from vibrom.report.columns import GONE, number
from vibrom.report.scores import NO_SPREAD, Scores, Spread, endings, offline
from vibrom.thesis import published as thesis


@dataclass(frozen=True)
class Question:
    """A column of every case."""

    experiment: str
    heading: str
    unit: str
    of: Callable[[Collection, Scores, str, str], Spread]  # of a scene and a method
    published: bool = True  # has the thesis a number?

    def thesis(self, case: str, method: str) -> tuple[float, str]:
        """Its number, and `fails` where it prints that instead."""
        return thesis.percent(self.experiment, case, method) if self.published else (np.nan, "")


QUESTIONS = (
    Question(
        "decay",
        "decay [%]",
        "%",
        lambda _, scores, *model: scores.spread(*model, "decay", "nmte_percent"),
    ),
    Question(
        "forced",
        "forced run [%]",
        "%",
        lambda _, scores, *model: scores.spread(*model, "forced", "nmte_percent"),
    ),
    Question(
        "frc",
        "response curve [%]",
        "%",
        lambda collection, _, *model: curves.error_of(collection, *model),
        published=False,
    ),
)


FOLDS = Question("branches", "folds", "", lambda *_: NO_SPREAD, published=False)


@dataclass(frozen=True)
class Cell:
    """One method, case and question."""

    value: float  # median over seeds, NaN where the median seed failed
    text: str
    spread: str = ""  # `0.41 to 0.45` where seeds differ
    ended: str = ""  # how the seeds ended, in words, unless all ended as asked
    thesis: str = ""
    best: bool = False


@dataclass(frozen=True)
class Answer:
    """The table."""

    cases: list[str]
    hardest: str  # of the cases
    questions: list[Question]  # that the run puts
    methods: list[str]
    cells: dict[tuple[str, str, str], Cell]  # case, method, experiment
    cost: dict[str, tuple[float, float]]  # method -> seconds offline, speed-up; of the hardest case

    def asked(self, case: str) -> list[Question]:
        """The columns of a case: that of folds where the full order has some."""
        return [one for one in self.questions if one is not FOLDS or folding(self, case)]


def of(collection: Collection, scores: Scores) -> Answer:
    """Of this run."""
    put = {key.name for key in collection.loaders if key.model != FULL_ORDER}
    questions = [question for question in QUESTIONS if question.experiment in put]
    cases, methods, cells = collection.scenes, collection.methods, {}
    for case in cases:
        for question in questions:
            spreads = {method: question.of(collection, scores, case, method) for method in methods}
            medians = [spread.median for spread in spreads.values()]
            best = np.nanmin(medians) if np.isfinite(medians).any() else np.nan
            for method, spread in spreads.items():
                ended = endings(collection, scores, case, method, question.experiment)
                published = question.thesis(case, method)
                made = cell(spread, ended, published, best)
                cells[case, method, question.experiment] = made
    hard = hardest_of(cases, methods, cells)
    if "branches" in put:
        questions.append(FOLDS)
        for case, method in product(cases, methods):
            cells[case, method, FOLDS.experiment] = folds(collection, scores, case, method)
    cost = {method: prices(scores, hard, method) for method in methods}
    return Answer(cases, hard, questions, methods, cells, cost)


def hardest_of(cases: list[str], methods: list[str], cells: dict) -> str:
    """The case whose best decay is worst; the last one where none was predicted."""
    least = {
        case: min(
            (c.value for m in methods if (c := cells.get((case, m, "decay"))) and c.best),
            default=-1.0,
        )
        for case in cases
    }
    return max(reversed(cases), key=lambda case: least[case], default="")


def cell(spread: Spread, ended: Tally, published: tuple[float, str], best: float) -> Cell:
    """As it is printed."""
    known, fails = published
    low, high = spread.minimum, spread.maximum
    range_ = ""
    if np.isfinite(spread.median) and low != high:
        top = number(high, 3) if np.isfinite(high) else "failed"
        range_ = f"{number(low, 3)} to {top}"
    return Cell(
        spread.median,
        number(spread.median, 3) if np.isfinite(spread.median) else "no value",
        range_,
        in_words(ended),
        fails or (number(known, 3) if np.isfinite(known) else ""),
        bool(np.isfinite(best) and spread.median == best),
    )


def folds(collection: Collection, scores: Scores, case: str, method: str) -> Cell:
    """Are the main folds of the full order's response curve there?"""
    truth = branches.curve(collection.find(case, FULL_ORDER, "branches"))
    found = scores.of_experiment(case, method, "branches", "folds")
    if truth is None or not found:
        return Cell(0.0, GONE)
    wanted = len(truth.folds)
    there = sum(score.value == wanted for score in found)
    words = {0: "no", len(found): "yes"}.get(there, f"{there} of {len(found)} seeds")
    return Cell(float(wanted), words if wanted or words != "yes" else "none to have")


def in_words(ended: Tally) -> str:
    """`left its training range`, or `of 33: 15 diverged, 2 left range`, the gravest first; empty
    where all ended as asked.
    """
    others = [one for one in ended if one is not Outcome.OK]
    if len(ended) == 1:
        return "".join(one.sentence for one in others)
    others.sort(key=lambda one: (-one.severity.value, -ended[one]))
    parts = ", ".join(f"{ended[one]} {one.replace('_', ' ')}" for one in others)
    return f"of {ended.total()}: {parts}" if parts else ""


def prices(scores: Scores, case: str, method: str) -> tuple[float, float]:
    """Seconds offline and speed-up of one decay."""
    own, full = (scores.seconds(case, model) for model in (method, FULL_ORDER))
    speed = full["decay_s"] / own["decay_s"] if own["decay_s"] > 0 else np.nan
    return offline(own), speed


def folding(answer: Answer, case: str) -> bool:
    """Was the curve followed through folds of the full order?"""
    cells = (answer.cells.get((case, method, FOLDS.experiment)) for method in answer.methods)
    return any(one is not None and one.value > 0.0 for one in cells)
