"""The answer in words, made from the numbers of the run: two sentences that say which model is best
and what it costs, and remarks on what they leave out.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from vibrom.report.answer import FOLDS, Answer, folding
from vibrom.report.collection import FULL_ORDER, Collection, described
from vibrom.report.columns import GONE, number
from vibrom.studies.parts import advice
from vibrom.thesis.labels import label


def of(answer: Answer) -> list[str]:
    """The two: the least errors of the hardest case and of the others; the price of them."""
    errors = "; ".join(part for part in (hardest(answer), others(answer)) if part)
    return [capital(text) for text in (errors, costs(answer)) if text]


def remarks(answer: Answer, collection: Collection) -> list[str]:
    """Which models have no value, which have the folds, and which effects each scene needs."""
    folds = [two_motions(answer, case) for case in answer.cases if folding(answer, case)]
    needs = "; ".join(advised(collection))
    return [capital(text) for text in (failures(answer), *folds, needs) if text]


def capital(text: str) -> str:
    """As a sentence."""
    return f"{text[0].upper()}{text[1:]}."


def two_motions(answer: Answer, case: str) -> str:
    """Whose response curve has the folds."""
    told: dict[str, list[str]] = {}
    for method in answer.methods:
        told.setdefault(answer.cells[case, method, FOLDS.experiment].text, []).append(label(method))
    every, none = told.pop("yes", []), told.pop("no", [])
    some = [f"{joined(names)} in {words}" for words, names in told.items() if words != GONE]
    parts = [f"{joined(every)} in every seed" if every else "", *some]
    know = joined([part for part in parts if part] or ["no model"])
    without = f"; without them: {joined(none)}" if none else ""
    return (
        f"in {case} the full order has two motions between its folds; with folds: {know}{without}"
    )


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
    """The best method of each question there, beside the best number of the thesis; questions with
    the same best method are told together.
    """
    told: dict[str, list[str]] = {}
    for question in answer.questions:
        for method in answer.methods:
            one = answer.cells[answer.hardest, method, question.experiment]
            if one.best:
                known = [question.thesis(answer.hardest, other)[0] for other in answer.methods]
                known = [value for value in known if np.isfinite(value)]
                beside = f", best of the thesis {number(min(known), 3)} %" if known else ""
                what = question.heading.partition(" [")[0]
                told.setdefault(label(method), []).append(f"{what} ({one.text} %{beside})")
                break
    if not told:
        return ""
    words = [f"{who} for the {joined(what)}" for who, what in told.items()]
    case = f"{answer.hardest}, the hardest," if len(answer.cases) > 1 else answer.hardest
    return f"in case {case} the least errors are those of {joined(words)}"


def others(answer: Answer) -> str:
    """The least errors of the other cases."""
    cases = [case for case in answer.cases if case != answer.hardest]
    found = [one.value for (case, *_), one in answer.cells.items() if case in cases and one.best]
    if not found:
        return ""
    return f"in {joined(cases)} the least errors are {reach(np.array(found), 2)} %"


def costs(answer: Answer) -> str:
    """What the model with the best decay of the hardest case costs there, and what all do."""
    known = {who: price for who, price in answer.cost.items() if np.isfinite(price).all()}
    if not known:
        return ""
    seconds, speed = np.array(list(known.values())).T
    price = (
        "{who} is ready after {seconds} s, training data included, and then computes the decay "
        "{speed} times as fast as the full order"
    )
    reached = {"seconds": reach(seconds, 2), "speed": reach(speed, 2)}
    cells = {who: answer.cells.get((answer.hardest, who, "decay")) for who in known}
    best = [who for who, one in cells.items() if one is not None and one.best]
    if not best or len(known) == 1:
        return price.format(who="a model of it", **reached)
    own = dict(zip(reached, (number(value, 2) for value in known[best[0]])))
    of_all = "; over all methods these are {seconds} s and {speed} times".format(**reached)
    return price.format(who=label(best[0]), **own) + of_all


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
