"""Figures 3.5 to 3.7: the predicted decay

Displacement of the probe in the test decay: full order (wide, pale)
and each reduced model (thin, dashed), with the NMTE over all displacements in the title. One seed
is drawn, named in the title: the median one by decay NMTE. The vertical axis is chosen by the
full order. A model that failed or left its training range says so in its panel.
"""

import numpy as np
from matplotlib.figure import Figure

from vibrom.report.collection import FULL_ORDER, at_probe
from vibrom.report.drawing import motions, panels
from vibrom.report.plots import Panel, Series

FAMILY = "models"
PLACE = 470
EACH = "scene"
ASKED = "decay"  # where that is asked only
DATA = ("decay",)
LAST = 5  # periods that the page shows at first


def draw(collection, scores, scene) -> Figure:
    """A panel a method."""
    return motions.draw(collection, scores, scene, "decay")


def plot(collection, scores) -> list[Panel]:
    """Displacement of the probe in the last periods of the test decay, where errors of the
    frequency have added up; double-click shows all of it. Of each method the median seed.
    """
    made = []
    for name in collection.scenes:
        truth, series, view = collection.find(name, FULL_ORDER, "test"), [], {}
        if truth is not None:
            motion = at_probe(truth, "probe_displacement")
            time, motion = panels.thinned(truth["time"].values, motion, limit=motions.POINTS)
            series.append(Series(FULL_ORDER, time - time[0], motion))
            last = float(time[-1] - time[0])
            late = time - time[0] > last - LAST * float(truth["period"])
            top = 1.5 * float(np.nanmax(np.abs(motion[late])))
            view = {"x": (last - LAST * float(truth["period"]), last), "y": (-top, top)}
        lines, lost = motions.predicted(collection, scores, name, "decay")
        series, notes = [*series, *lines], lost
        words = "time since release [s]", "probe displacement [m]"
        made.append(Panel(name, *words, series, view=view, notes=notes))
    return made
