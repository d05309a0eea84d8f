"""Figure 3.12: forced response curves, amplitude

Largest displacement of the probe in the last forced period against the forcing frequency, every
point started from rest. One seed of each method is drawn: the median one by decay NMTE. Points
without a value are missing from the curve; below the panel stands how many are left and how the
others ended. The lower panel has the size of the
difference to the full order, in percent of its peak.
"""

import numpy as np

from vibrom.report.collection import FULL_ORDER, answered, at_probe
from vibrom.report.drawing import response

FAMILY = "models"
PLACE = 540
EACH = "run"
ASKED = "frc"  # where that is asked only
DATA = ("frc",)
AXES = ("probe amplitude [m]", "difference [%]")


def draw(collection, scores, scene=None):
    """The vertical axis is chosen by the full order, so that a blow-up does not flatten it."""
    figure, upper = response.draw(collection, scores, "amplitude", AXES)
    for panel, name in zip(upper, collection.scenes):
        truth = collection.find(name, FULL_ORDER, "frc")
        if answered(truth) and np.isfinite(at_probe(truth, "amplitude")).any():
            top = min(1.5 * float(np.nanmax(at_probe(truth, "amplitude"))), panel.dataLim.y1)
            panel.set_ylim(-0.03 * top, 1.08 * top)
    return figure


def plot(collection, scores):
    """Largest displacement of the probe in the last period against the forcing frequency, every
    point started from rest. Every seed is there, those that figures do not draw are faint; the
    pointer tells how a point ended.
    """
    return response.plot(collection, scores, "amplitude", AXES[0])
