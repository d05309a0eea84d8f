"""What the answer is: a few sentences made from the numbers of the run, and the table below them.

The table has a row a method and, of each case, a column a question: the median over seeds, the
seeds' range, how they ended in words, and the thesis's number. The best median of a column is
marked.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from itertools import product

import numpy as np

from vibrom.artefacts.outcome import Outcome, Tally
from vibrom.report import branches, curves
from vibrom.report.collection import FULL_ORDER, Collection, described
from vibrom.report.columns import GONE, number
from vibrom.report.scores import NO_SPREAD, Scores, Spread, endings, offline
from vibrom.studies.parts import advice
from vibrom.thesis import published as thesis
from vibrom.thesis.labels import label


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
    """The table, and the sentences."""

    cases: list[str]
    hardest: str  # of the cases
    questions: list[Question]  # that the run puts
    methods: list[str]
    cells: dict[tuple[str, str, str], Cell]  # case, method, experiment
    cost: dict[str, tuple[float, float]]  # method -> seconds offline, speed-up; of the hardest case
    sentences: list[str] = field(default_factory=list)

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
    bare = Answer(cases, hard, questions, methods, cells, cost)
    return replace(bare, sentences=[*sentences(bare), *needs(collection)])


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
    """`2 of 3 left its training range`; empty where all ended as asked."""
    total = ended.total()
    parts = [
        f"{count} of {total} {one.sentence}" if count < total else one.sentence
        for one, count in ended.items()
        if one is not Outcome.OK
    ]
    return "; ".join(parts)


def prices(scores: Scores, case: str, method: str) -> tuple[float, float]:
    """Seconds offline and speed-up of one decay."""
    own, full = (scores.seconds(case, model) for model in (method, FULL_ORDER))
    speed = full["decay_s"] / own["decay_s"] if own["decay_s"] > 0 else np.nan
    return offline(own), speed


def sentences(answer: Answer) -> list[str]:
    """What is best in the hardest case and in the others; what that costs, and what fails; which
    models have the folds.
    """
    first = "; ".join(part for part in (hardest(answer), others(answer)) if part)
    second = "; ".join(part for part in (costs(answer), failures(answer)) if part)
    third = "; ".join(two_motions(answer, case) for case in answer.cases if folding(answer, case))
    return [f"{text[0].upper()}{text[1:]}." for text in (first, second, third) if text]


def folding(answer: Answer, case: str) -> bool:
    """Was the curve followed through folds of the full order?"""
    cells = (answer.cells.get((case, method, FOLDS.experiment)) for method in answer.methods)
    return any(one is not None and one.value > 0.0 for one in cells)


def two_motions(answer: Answer, case: str) -> str:
    """Whose response curve has the folds."""
    told: dict[str, list[str]] = {}
    for method in answer.methods:
        told.setdefault(answer.cells[case, method, FOLDS.experiment].text, []).append(label(method))
    every, none = told.pop("yes", []), told.pop("no", [])
    some = [f"{joined(names)} in {words}" for words, names in told.items() if words != GONE]
    parts = [f"{joined(every)} in every seed" if every else "", *some]
    know = joined([part for part in parts if part] or ["no model"])
    wrong = f", {joined(none)} not" if none else ""
    return f"in {case} two motions are possible between the folds of the full order: {know}{wrong}"


def needs(collection: Collection) -> list[str]:
    """Which effects each scene needs, in a sentence."""
    text = "; ".join(advised(collection))
    return [f"{text[0].upper()}{text[1:]}."] if text else []


def advised(collection: Collection) -> list[str]:
    """Which effects each scene needs, as the study of ablation found: a line a scene."""
    parts = []
    for scene in collection.scenes:
        study = collection.find(scene, FULL_ORDER, "ablation")
        if study is not None and "advised" in study:
            structure = collection.find(scene, FULL_ORDER, "structure")
            parts.append(advice.line(study, scene, list(described(structure, "effects"))))
    return parts


def hardest(answer: Answer) -> str:
    """The best method of each question there, beside the best number of the thesis."""
    words = []
    for question in answer.questions:
        for method in answer.methods:
            one = answer.cells[answer.hardest, method, question.experiment]
            if one.best:
                known = [question.thesis(answer.hardest, other)[0] for other in answer.methods]
                known = [value for value in known if np.isfinite(value)]
                beside = f", best of the thesis {number(min(known), 3)} %" if known else ""
                what = question.heading.partition(" [")[0]
                words.append(f"{label(method)} for the {what} ({one.text} %{beside})")
                break
    if not words:
        return ""
    return f"in case {answer.hardest}, the hardest, the least errors are those of {joined(words)}"


def others(answer: Answer) -> str:
    """The least errors of the other cases."""
    cases = [case for case in answer.cases if case != answer.hardest]
    found = [one.value for (case, *_), one in answer.cells.items() if case in cases and one.best]
    if not found:
        return ""
    return f"in {joined(cases)} the least errors are {reach(np.array(found), 2)} %"


def costs(answer: Answer) -> str:
    """What a model costs in the hardest case."""
    known = [price for price in answer.cost.values() if np.isfinite(price).all()]
    if not known:
        return ""
    seconds, speed = np.array(known).T
    return (
        f"a model of it is ready after {reach(seconds, 2)} s, training data included, and then "
        f"computes the decay {reach(speed, 2)} times as fast as the full order"
    )


def failures(answer: Answer) -> str:
    """Where methods have no value."""
    lost: dict[str, list[str]] = {}
    for case in answer.cases:
        for question in answer.questions:
            without = [
                label(method)
                for method in answer.methods
                if not np.isfinite(answer.cells[case, method, question.experiment].value)
            ]
            if without:
                what = question.heading.partition(" [")[0]
                lost.setdefault(joined(without), []).append(f"{what} of {case}")
    if not lost:
        return "every method has a value for every question" if answer.cells else ""
    parts = [f"{who} on the {joined(where)}" for who, where in lost.items()]
    return f"without a value: {'; '.join(parts)}"


def reach(values: np.ndarray, digits: int) -> str:
    """`0.7 to 2.9`."""
    low, high = number(float(values.min()), digits), number(float(values.max()), digits)
    return low if low == high else f"{low} to {high}"


def joined(words: Iterable[str]) -> str:
    """`a, b and c`."""
    *most, last = words
    return f"{', '.join(most)} and {last}" if most else last
