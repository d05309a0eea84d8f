"""The measured response curve

Half the range of the measured channel at each frequency of the load: dots, as it was measured;
lines, as each model predicts it, the motion carried on from one frequency to the next in the order
of the sweep. Where the strength of the load is not known, it was chosen such that the model agrees
with the point in a circle. One seed of each method is drawn: the median one by decay NMTE. In
parentheses, the median error of the amplitude.
"""

import numpy as np
from matplotlib.figure import Figure

from vibrom.report.collection import FULL_ORDER, answered
from vibrom.report.drawing import layout, panels, style
from vibrom.report.drawing.response import THIN
from vibrom.thesis.labels import label

FAMILY = "models"
PLACE = 566
EACH = "scene"
DATA = ("measured_response",)
RECORDED = True  # of recorded scenes only
ASKED = "measured_response"  # where that is asked only


def draw(collection, scores, scene) -> Figure:
    """One panel."""
    figure, (panel,) = layout.grid(1, height=2.0)
    panel.set(title=scene, xlabel="angular frequency [rad/s]", ylabel="amplitude [m]")
    known = collection.find(scene, FULL_ORDER, "structure")
    if known is None or "response_frequency" not in known:
        layout.words(panel, "no response was measured")
        return figure
    frequency, amplitude = (known[f"response_{what}"].values for what in ("frequency", "amplitude"))
    panel.plot(frequency, amplitude, "o", color="black", markersize=3.5, label="measured")
    if "calibration_point" in known:
        at = int(known["calibration_point"])
        ring = {"color": "black", "markersize": 9, "markerfacecolor": "none"}
        panel.plot(frequency[at], amplitude[at], "o", **ring)
    for method, look in style.looks(collection.methods).items():
        seed, answer = panels.drawn(collection, scores, scene, method, "measured_response")
        if answered(answer) and "half_range" in answer:
            error = scores.value(scene, method, seed, *MEDIAN)
            name = f"{label(method)} ({error:.2g} %)"
            panel.plot(frequency, answer["half_range"].values, **look | THIN, label=name)
    panels.breathe(panel, amplitude)
    layout.legend(figure, *layout.of_panels(figure))
    return figure


MEDIAN = ("measured_response", "amplitude_error_median_percent")


def seen(collection, scores, scene) -> str:
    """The median error of each method."""
    found = []
    for method in collection.methods:
        error = scores.spread(scene, method, *MEDIAN, worst=True).median
        if np.isfinite(error):
            found.append(f"{label(method)}: {error:.2g} % median error of the amplitude")
    return "; ".join(found) or "No response in this run."
