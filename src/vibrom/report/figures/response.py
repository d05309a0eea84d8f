"""Motions under loads with signals

Displacement of the probe from rest under the loads that have signals of their own: recorded, a
blow, a chirp, noise. Full order wide and pale, each reduced model thin and dashed, with the NMTE
over all displacements in the title. One seed is drawn, named in the title: the median one by decay
NMTE. The vertical axis is chosen by the full order.
"""

from matplotlib.figure import Figure

from vibrom.report.collection import FULL_ORDER, answered, at_probe
from vibrom.report.drawing import layout, motions, panels
from vibrom.report.plots import Panel, Series

FAMILY = "models"
PLACE = 495
EACH = "scene"
DATA = ("response",)
ASKED = "response"  # where that is asked only


def draw(collection, scores, scene) -> Figure:
    """A panel a method."""
    if collection.find(scene, FULL_ORDER, "response") is not None:
        return motions.draw(collection, scores, scene, "response")
    figure, (panel,) = layout.grid(1)
    panel.set(title=scene, xlabel="time [s]", ylabel="probe [m]")
    layout.words(panel, "no load of this scene has a signal")
    return figure


def plot(collection, scores) -> list[Panel]:
    """Displacement of the probe from rest under the loads that have signals of their own. Of each
    method the median seed.
    """
    made = []
    for scene in collection.scenes:
        truth = collection.find(scene, FULL_ORDER, "response")
        if not answered(truth):
            continue
        motion = at_probe(truth, "probe_displacement")
        time, motion = panels.thinned(truth["time"].values, motion, limit=motions.POINTS)
        lines, notes = motions.predicted(collection, scores, scene, "response")
        words = "time [s]", "probe displacement [m]"
        series = [Series(FULL_ORDER, time, motion), *lines]
        made.append(Panel(scene, *words, series, notes=notes))
    return made
