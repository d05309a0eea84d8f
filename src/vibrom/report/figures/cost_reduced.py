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
from vibrom.report.drawing import panels
from vibrom.report.plots import FRONT, Panel, Series
from vibrom.studies.parts.work_precision import front
from vibrom.thesis.labels import label

FAMILY = "cost"
PLACE = 620
EACH = "run"
DATA = ("cost_reduced",)
GLANCE = True
AXES = ("offline: data, mapping, dynamics [s]", "online: one answer [s]")
TRUTH = {"decay": "test", "forced": "forced", "frc": "frc"}  # what the full-order model answers


def draw(collection, scores, scene=None) -> Figure:
    """Two rows a scene, a column a question."""
    found = cost.pooled(collection)
    scenes, looks = dict.fromkeys(one.scene for one in found), drawing.looks(collection, found)
    rows = 2 * max(1, len(scenes))
    figure = Figure(figsize=(8.6, 2.6 * rows))
    axes = figure.subplots(rows, 3, squeeze=False)
    for row, line in enumerate(axes):
        for panel, words in zip(line, drawing.ERRORS.values()):
            panel.set(ylabel=words, xlabel=AXES[row % 2], xscale="log", yscale="log")
    if not scenes:
        panels.words(axes[0, 0], drawing.NOT_STUDIED)
    handles: dict = {}
    for name, above, below in zip(scenes, axes[::2], axes[1::2]):
        mine = [one for one in found if one.scene == name]
        above[0].set_title(name)
        for question, offline, online in zip(drawing.ERRORS, above, below):
            handles |= points(offline, mine, "offline", question, looks)
            handles |= points(online, mine, question, question, looks)
            drawing.name_silent(offline, mine, question)
            truth = collection.find(name, FULL_ORDER, TRUTH[question])
            mark(online, float(scalar(truth, "seconds")))
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
        panel.plot(*varied, **look | {"markersize": 3.2, "markeredgewidth": 0.7})
        usual = drawing.known(group, price, question, configured=True)
        if usual.size:
            large = look | {"markersize": 7, "markeredgewidth": 1.5}
            handles[label(method)] = panel.plot(*usual, **large)[0]
    seconds = np.array([drawing.cost(one, price) for one in found])
    errors = np.array([one.error[question] for one in found])
    best = front(seconds, errors)
    if len(best):
        grey = {"where": "post", "color": "0.6", "linewidth": 1.4, "zorder": 0}
        handles["Pareto front"] = panel.step(seconds[best], errors[best], **grey)[0]
    return handles


def mark(panel, full: float) -> None:
    """The seconds of the full order, dashed."""
    if np.isfinite(full):
        panel.axvline(full, color="black", linewidth=1.1, linestyle=(0, (4, 2)))
        where = {"rotation": 90, "ha": "right", "va": "top", "fontsize": 6.5}
        panel.text(full, 0.98, "full order ", **where, transform=panel.get_xaxis_transform())


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
