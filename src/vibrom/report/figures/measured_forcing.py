"""Motion under a recorded signal

Above, the signal; below, the first channel: black, as it was recorded, and in colour as each model
predicts it from the first recorded state, having learnt from decays alone. All of it on the left,
and on the right the part about its largest displacement. One seed of each method is drawn: the
median one by decay NMTE. In parentheses, the NMTE of the channels.
"""

import numpy as np
from matplotlib.figure import Figure

from vibrom.report.collection import answered
from vibrom.report.drawing import layout, panels, style
from vibrom.thesis.labels import label

FAMILY = "models"
PLACE = 567
EACH = "scene"
DATA = ("measured_forcing",)
RECORDED = True  # of recorded scenes only
ASKED = "measured_forcing"  # where that is asked only
ERROR = ("measured_forcing", "nmte_percent")
LINE = {"linewidth": 0.9, "marker": ""}
NEAR = 0.05  # of the recording, on each side of its largest displacement


def draw(collection, scores, scene) -> Figure:
    """A column for the whole, one for a part."""
    figure, axes = layout.grid(4)
    for column in range(2):
        axes[column].set(title=scene, xlabel="time [s]", ylabel="signal")
        axes[2 + column].set(xlabel="time [s]", ylabel="displacement [m]")
    shown = False
    for method, look in style.looks(collection.methods).items():
        seed, answer = panels.drawn(collection, scores, scene, method, "measured_forcing")
        if not answered(answer) or "probe_true" not in answer:
            continue
        time, true = answer["time"].values, answer["probe_true"].values[0]
        top = int(np.abs(true).argmax())
        count = max(2, int(NEAR * len(time)))
        parts = slice(None), slice(max(0, top - count), top + count)
        for column, part in enumerate(parts):
            if not shown:
                axes[column].plot(time[part], answer["signal"].values[part], color="0.4", lw=0.6)
                axes[2 + column].plot(time[part], true[part], color="black", label="recorded")
            found = answer["probe_displacement"].values[0]
            name = f"{label(method)} ({scores.value(scene, method, seed, *ERROR):.2g} %)"
            axes[2 + column].plot(time[part], found[part], **look | LINE, label=name)
        shown = True
    if not shown:
        layout.words(axes[0], "no model answered")
        return figure
    layout.legend(figure, *axes[2].get_legend_handles_labels())
    return figure


def seen(collection, scores, scene) -> str:
    """The error of each method."""
    found = []
    for method in collection.methods:
        error = scores.spread(scene, method, *ERROR, worst=True).median
        if np.isfinite(error):
            found.append(f"{label(method)}: NMTE {error:.2g} %")
    return "; ".join(found) or "No motion under a signal in this run."
