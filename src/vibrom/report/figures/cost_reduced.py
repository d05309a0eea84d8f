"""Accuracy of the methods against what it costs

Every setting that was studied (small markers), models as configured (large markers, median over
seeds), and the Pareto front of all. Top: error over seconds offline, training data included;
bottom: over seconds of one answer, beside those of the full order (dashed). Down and to the left
is better.
"""

from collections.abc import Iterator

import numpy as np
from matplotlib.figure import Figure

from vibrom.report import cost
from vibrom.report.collection import FULL_ORDER, scalar
from vibrom.report.drawing import cost as drawing
from vibrom.report.drawing import layout
from vibrom.report.plots import FRONT, Panel, Series
from vibrom.studies.parts.work_precision import front
from vibrom.thesis.labels import label

FAMILY = "cost"
PLACE = 620
EACH = "scene"
DATA = ("cost_reduced",)
GLANCE = True
AXES = ("offline: data, mapping, dynamics [s]", "online: one answer [s]")
TRUTH = {"decay": "test", "forced": "forced", "frc": "frc"}  # what the full-order model answers


def draw(collection, scores, scene) -> Figure:
    """A row a question: offline on the left, online on the right."""
    mine = [one for one in cost.pooled(collection) if one.scene == scene]
    looks = drawing.looks(collection, mine)
    figure, axes = layout.grid(2 * len(drawing.ERRORS), height=1.3, sharey="row")
    handles: dict = {}
    for question, offline, online in zip(drawing.ERRORS, axes[::2], axes[1::2]):
        for panel, axis in zip((offline, online), AXES):
            words = {"ylabel": drawing.ERRORS[question], "xlabel": axis}
            panel.set(xscale="log", yscale="log", **words)
        if not mine:
            layout.words(offline, drawing.NOT_STUDIED)
            continue
        offline.set_title(f"{scene}, {drawing.ERRORS[question].partition(':')[0]}")
        handles |= points(offline, mine, "offline", question, looks)
        handles |= points(online, mine, question, question, looks)
        drawing.name_silent(offline, mine, question)
        truth = collection.find(scene, FULL_ORDER, TRUTH[question])
        handles |= mark(online, float(scalar(truth, "seconds")))
    drawing.finish(figure, handles, looks)
    return figure


def points(panel, found: list[cost.Pooled], price: str, question: str, looks: dict) -> dict:
    """Small markers for settings that were varied, large ones as configured, and a grey line for
    the front of all.
    """
    handles = {}
    for method, group in cost.of_methods(found).items():
        look = looks[method] | {"linestyle": "none"}
        varied = drawing.known(group, price, question, configured=False)
        panel.plot(*varied, **look | {"markersize": 2.6, "markeredgewidth": 0.6})
        usual = drawing.known(group, price, question, configured=True)
        if usual.size:
            large = look | {"markersize": 5.5, "markeredgewidth": 1.2}
            handles[label(method)] = panel.plot(*usual, **large)[0]
    seconds = np.array([drawing.cost(one, price) for one in found])
    errors = np.array([one.error[question] for one in found])
    best = front(seconds, errors)
    if len(best):
        grey = {"where": "post", "color": "0.6", "linewidth": 1.4, "zorder": 0}
        handles["Pareto front"] = panel.step(seconds[best], errors[best], **grey)[0]
    return handles


def mark(panel, full: float) -> dict:
    """The seconds of the full order, dashed; by its label."""
    if not np.isfinite(full):
        return {}
    look = {"color": "black", "linewidth": 1.1, "linestyle": (0, (4, 2))}
    return {label(FULL_ORDER): panel.axvline(full, **look)}


def plot(collection, scores) -> list[Panel]:
    """Small markers: settings that were varied, named under the pointer; large ones: as configured,
    median over seeds. Grey: the Pareto front of all; dotted: the full order.
    """
    found, made = cost.pooled(collection), []
    for scene in dict.fromkeys(one.scene for one in found):
        mine = [one for one in found if one.scene == scene]
        for question, words in drawing.ERRORS.items():
            for price, axis in zip(("offline", question), AXES):
                lines = [*pareto(mine, price, question), *settings(mine, price, question)]
                if price == question:
                    full = float(
                        scalar(collection.find(scene, FULL_ORDER, TRUTH[question]), "seconds")
                    )
                    lines = [*beside(full, lines), *lines]
                title = f"{scene}, {words.partition(':')[0]}, {axis.partition(':')[0]}"
                made.append(Panel(title, axis, words, lines, log="xy", switch="xy"))
    return made


def settings(found: list[cost.Pooled], price: str, question: str) -> Iterator[Series]:
    """Of each method: small markers for settings that were varied, large ones as configured."""
    for method, group in cost.of_methods(found).items():
        for configured, size in ((False, 3.2), (True, 7.0)):
            chosen = [one for one in group if (one.varied == cost.CONFIGURED) == configured]
            x = np.array([drawing.cost(one, price) for one in chosen])
            y = np.array([one.error[question] for one in chosen])
            notes = [f"{one.varied} {one.set_to}".strip() for one in chosen]
            if np.isfinite(y).any():
                look = {"markersize": size}
                yield Series(method, x, y, mode="markers", notes=notes, look=look)


def pareto(found: list[cost.Pooled], price: str, question: str) -> list[Series]:
    """The settings that no other one beats in both."""
    seconds = np.array([drawing.cost(one, price) for one in found])
    errors = np.array([one.error[question] for one in found])
    best = front(seconds, errors)
    return [Series(FULL_ORDER, seconds[best], errors[best], **FRONT)] if len(best) > 1 else []


def beside(seconds: float, lines: list[Series]) -> list[Series]:
    """The full order as a vertical line."""
    errors = np.concatenate([one.y for one in lines] or [np.zeros(0)])
    errors = errors[np.isfinite(errors)]
    if not (np.isfinite(seconds) and errors.size):
        return []
    ends = np.array([errors.min(), errors.max()])
    return [Series(FULL_ORDER, np.full(2, seconds), ends, look={"linestyle": ":"})]
