"""Figure 3.13: forced response curves, phase

Phase of the probe's first harmonic in the last period relative to the forcing, against the
forcing frequency. One seed of each method is drawn: the median one by decay NMTE. Points without
a value are missing from the curve; below the panel stands how many are left and how the others
ended. The lower panel has the size of the difference to the full order.
"""

import numpy as np

from vibrom.report.drawing import response

FAMILY = "models"
PLACE = 550
EACH = "run"
ASKED = "frc"  # where that is asked only
DATA = ("frc",)
TICKS = {-2: r"$-2\pi$", -1.5: r"$-3\pi/2$", -1: r"$-\pi$", -0.5: r"$-\pi/2$", 0: "0"}
AXES = ("phase of the probe [rad]", "difference [rad]")


def draw(collection, scores, scene=None):
    """Down from zero."""
    figure, upper = response.draw(collection, scores, "phase", AXES)
    for panel in upper:
        low = min(panel.dataLim.y0 if panel.lines else 0.0, -np.pi)
        panel.set_yticks([part * np.pi for part in TICKS], list(TICKS.values()))
        panel.set_ylim(1.06 * low, 0.25)
    return figure


def plot(collection, scores):
    """Phase of the probe's first harmonic relative to the forcing, every point started from rest.
    Every seed is there, those that figures do not draw are faint.
    """
    return response.plot(collection, scores, "phase", AXES[0])
