"""Accuracy against cost

NMTE of the test decay against the seconds spent before the first prediction (training data,
mapping, dynamics; left) and the seconds one decay takes (right). One marker a method: median over
seeds, the line spans the seeds that have a value. Down and to the left is better. The dashed line
is the full-order model. Methods whose median seed failed have no marker and are named in the
panel.
"""

import numpy as np
from matplotlib.figure import Figure

from vibrom.report.collection import FULL_ORDER
from vibrom.report.drawing import layout, panels, style
from vibrom.report.plots import FRONT, Panel, Series
from vibrom.report.scores import endings, offline
from vibrom.studies.parts.work_precision import front
from vibrom.thesis.labels import label

FAMILY = "models"
PLACE = 410
EACH = "run"
DATA = ("decay", "run_times")
GLANCE = True
FLOOR = 1e-5  # [s] a cost measured as zero is drawn here: the axis is logarithmic
AXES = ("offline: data, mapping, dynamics [s]", "online: one decay [s]")


def draw(collection, scores, scene=None) -> Figure:
    """A row a scene: offline on the left, online on the right."""
    scenes = collection.scenes or [""]
    figure, axes = layout.grid(2 * len(scenes), height=1.3, sharex="col", sharey=True)
    pairs = list(zip(axes[::2], axes[1::2]))
    handles, looks = {}, style.looks(collection.methods)
    for column, name in zip(pairs, scenes):
        for panel, words in zip(column, ("offline [s]", "online [s]")):
            panel.set(xscale="log", yscale="log", xlabel=words)
        column[0].set_title(name)
        lost = []
        for method, look in looks.items():
            error = scores.spread(name, method, "decay", "nmte_percent")
            if np.isfinite(error.median):
                seconds = scores.seconds(name, method)
                for panel, price in zip(column, (offline(seconds), seconds["decay_s"])):
                    handles |= mark(panel, price, error, method, look)
            else:
                ended = endings(collection, scores, name, method, "decay")
                lost.append(f"{label(method)}: {ended}")
        handles |= mark_full_order(column[1], scores.seconds(name, FULL_ORDER)["decay_s"])
        if lost:
            layout.words(column[0], "no median:\n" + "\n".join(lost))
    for panel in axes:
        panel.set_ylabel("decay NMTE [%]")
        panels.decades(panel.xaxis)
        panels.decades(panel.yaxis)
    layout.legend(figure, handles.values(), handles)
    return figure


def mark(panel, price: float, error, method: str, look: dict) -> dict:
    """The median as a marker, the seeds that have a value as a line; by its label."""
    if not np.isfinite(price):
        return {}
    price = max(price, FLOOR)
    marker = look | {"linestyle": "none", "markersize": 5, "markeredgewidth": 1.1}
    top = error.maximum if np.isfinite(error.maximum) else error.median
    panel.plot([price] * 2, [error.minimum, top], color=look["color"], linewidth=1.2, zorder=1)
    return {label(method): panel.plot(price, error.median, **marker)[0]}


def mark_full_order(panel, price: float) -> dict:
    """A dashed line at its seconds; by its label."""
    if not np.isfinite(price):
        return {}
    look = {"color": "black", "linewidth": 1.2, "linestyle": (0, (4, 2))}
    return {label(FULL_ORDER): panel.axvline(max(price, FLOOR), **look)}


def plot(collection, scores) -> list[Panel]:
    """A marker a method: median over seeds, the bar spans those that have a value. Over the seconds
    before the first prediction (offline) and those of one decay (online); down and to the left is
    better. Grey: the Pareto front; dotted: the full order.
    """
    made = []
    for name in collection.scenes:
        lost, points = [], {"offline": [], "online": []}
        for method in collection.methods:
            error, seconds = (
                scores.spread(name, method, "decay", "nmte_percent"),
                scores.seconds(name, method),
            )
            if not np.isfinite(error.median):
                ended = endings(collection, scores, name, method, "decay")
                lost.append(f"{label(method)}: {ended}.")
                continue
            top = error.maximum if np.isfinite(error.maximum) else error.median
            for kind, price in (("offline", offline(seconds)), ("online", seconds["decay_s"])):
                ends = {"low": np.array([error.minimum]), "high": np.array([top])}
                look = {"markersize": 6}
                x, y = np.array([max(price, FLOOR)]), np.array([error.median])
                points[kind].append(Series(method, x, y, mode="markers", look=look, **ends))
        full = scores.seconds(name, FULL_ORDER)["decay_s"]
        for (kind, series), axis in zip(points.items(), AXES):
            limits = {"log": "xy", "switch": "xy", "notes": lost}
            title = f"{name}, {kind}"
            reference = [upright(full, series)] if kind == "online" and np.isfinite(full) else []
            lines = [*reference, *pareto(series), *series]
            made.append(Panel(title, axis, "decay NMTE [%]", lines, **limits))
    return made


def upright(seconds: float, series: list[Series]) -> Series:
    """The full order as a vertical line beside these points."""
    errors = np.array([one.y[0] for one in series] or [1.0])
    ends = np.array([errors.min() / 2, errors.max() * 2])
    return Series(FULL_ORDER, np.full(2, max(seconds, FLOOR)), ends, look={"linestyle": ":"})


def pareto(series: list[Series]) -> list[Series]:
    """Through the methods that no other one beats in both."""
    x, y = (np.array([getattr(one, axis)[0] for one in series]) for axis in "xy")
    best = front(x, y)
    return [Series(FULL_ORDER, x[best], y[best], **FRONT)] if len(best) > 1 else []
