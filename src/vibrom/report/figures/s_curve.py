"""Periodic motions against the forcing, at one frequency

Largest displacement of the probe in a period of every periodic motion that was found, against the
amplitude of the forcing: stable motions drawn through, unstable ones dotted, main folds marked.
Behind each model stands the full order. As the forcing grows, motions jump up at the fold to the
right; as it shrinks, they jump down at the fold to the left. One seed of each method is drawn: the
median one by decay NMTE.
"""

from matplotlib.figure import Figure

from vibrom.report.branches import curve
from vibrom.report.drawing import branches
from vibrom.report.plots import Panel

FAMILY = "models"
PLACE = 562
EACH = "scene"
DATA = ("s_curve",)
ASKED = "s_curve"  # where that is asked only


def draw(collection, scores, scene) -> Figure:
    """A panel a model."""
    return branches.draw(collection, scores, scene, "s_curve", show, whole="s_curve")


def show(panel, collection, scene, model, seed) -> None:
    """The model's curve on the full order's."""
    branches.marked(panel, curve(collection.find(scene, model, "s_curve", seed)))


def plot(collection, scores) -> list[Panel]:
    """Largest displacement of the probe in a period of every periodic motion that was found at one
    frequency, against the forcing: stable motions drawn through, unstable ones dotted. Of each
    method the median seed. Shown at first is the neighbourhood of the full order's folds; a double
    click shows all.
    """
    return branches.switched(collection, scores, "s_curve", branches.S_AXES)
