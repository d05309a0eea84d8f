"""Accuracy against cost

NMTE of the test decay against the seconds spent before the first prediction (training data,
mapping, dynamics; top) and the seconds one decay takes (bottom). One marker a method: median over
seeds, the line spans the seeds that have a value. Down and to the left is better. The dashed line
is the full-order model. Methods whose median seed failed have no marker and are named in the
panel.
"""

import numpy as np
from matplotlib.figure import Figure

from vibrom.report.collection import FULL_ORDER
from vibrom.report.drawing import panels, style
from vibrom.report.scores import endings, offline
from vibrom.thesis.labels import label

FAMILY = "models"
PLACE = 410
EACH = "run"
GLANCE = True
FLOOR = 1e-5  # [s] a cost measured as zero is drawn here: the axis is logarithmic
AXES = ("offline: data, mapping, dynamics [s]", "online: one decay [s]")


def draw(collection, scores, scene=None) -> Figure:
    """A column a scene: offline above, online below."""
    scenes = collection.scenes or [""]
    figure = Figure(figsize=(3.1 * len(scenes) + 0.4, 5.0))
    axes = figure.subplots(2, len(scenes), squeeze=False, sharex="row", sharey=True)
    handles, looks = {}, style.looks(collection.methods)
    for column, name in zip(axes.T, scenes):
        for panel, words in zip(column, AXES):
            panel.set(xscale="log", yscale="log", ylabel="decay NMTE [%]", xlabel=words)
            panel.tick_params(labelleft=True)
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
        mark_full_order(column[1], scores.seconds(name, FULL_ORDER)["decay_s"])
        if lost:
            panels.words(column[0], "no median:\n" + "\n".join(lost), place="above")
    for panel in axes.flat:
        panels.decades(panel.xaxis)
        panels.decades(panel.yaxis)
    figure.legend(list(handles.values()), list(handles), loc="outside lower center", ncols=4)
    return figure


def mark(panel, price: float, error, method: str, look: dict) -> dict:
    """The median as a marker, the seeds that have a value as a line; by its label."""
    if not np.isfinite(price):
        return {}
    price = max(price, FLOOR)
    marker = look | {"linestyle": "none", "markersize": 7, "markeredgewidth": 1.4}
    top = error.maximum if np.isfinite(error.maximum) else error.median
    panel.plot([price] * 2, [error.minimum, top], color=look["color"], linewidth=1.2, zorder=1)
    return {label(method): panel.plot(price, error.median, **marker)[0]}


def mark_full_order(panel, price: float) -> None:
    """A dashed line at its seconds."""
    if np.isfinite(price):
        price = max(price, FLOOR)
        panel.axvline(price, color="black", linewidth=1.2, linestyle=(0, (4, 2)))
        where = {"rotation": 90, "ha": "right", "va": "bottom", "fontsize": 7}
        panel.text(price, 0.02, "full order ", **where, transform=panel.get_xaxis_transform())
