"""Figure 3.13: forced response curves, phase

Phase of the probe's first harmonic in the last period relative to the forcing, against the
forcing frequency. One seed of each method is drawn: the median one by decay NMTE. Points without
a value are missing from the curve, and the panel counts what is left and says how the others
ended.
"""

import numpy as np

from vibrom.report.drawing import response

FAMILY = "models"
PLACE = 550
EACH = "run"
DATA = ("frc",)
TICKS = {-2: r"$-2\pi$", -1.5: r"$-3\pi/2$", -1: r"$-\pi$", -0.5: r"$-\pi/2$", 0: "0"}


def draw(collection, scores, scene=None):
    """Down from zero, with room for the notes below."""
    figure, notes = response.draw(collection, scores, "phase", "phase of the probe [rad]", "below")
    for panel, count in zip(figure.axes, notes):
        low = min(panel.dataLim.y0 if panel.lines else 0.0, -np.pi)
        panel.set_yticks([part * np.pi for part in TICKS], list(TICKS.values()))
        panel.set_ylim(low * (1.06 + 0.075 * count), 0.25)
    return figure


def plot(collection, scores):
    """Phase of the probe's first harmonic relative to the forcing, every point started from rest.
    Every seed is there, those that figures do not draw are faint.
    """
    return response.plot(collection, scores, "phase", "phase [rad]")
