"""Response curves with all their branches

Largest displacement of the probe in a period of every periodic motion that was found, against the
forcing frequency: stable motions drawn through, unstable ones dotted, main folds marked. Behind
each model stands the full order. One seed of each method is drawn: the median one by decay NMTE.
The axes are chosen by the full order: where its curve folds, the neighbourhood of the folds is
shown.
"""

from matplotlib.figure import Figure

from vibrom.report.branches import curve
from vibrom.report.drawing import branches
from vibrom.report.plots import Panel

FAMILY = "models"
PLACE = 560
EACH = "scene"
DATA = ("folds",)
ASKED = "branches"  # where that is asked only
GLANCE = True


def draw(collection, scores, scene) -> Figure:
    """A panel a model."""
    return branches.draw(collection, scores, scene, "branches", show)


def show(panel, collection, scene, model, seed) -> None:
    """The model's curve on the full order's."""
    branches.marked(panel, curve(collection.find(scene, model, "branches", seed)))


def plot(collection, scores) -> list[Panel]:
    """Largest displacement of the probe in a period of every periodic motion that was found, stable
    motions drawn through, unstable ones dotted; the pointer tells what is special about a motion.
    Of each method the median seed. Shown at first is the neighbourhood of the full order's folds; a
    double click shows all.
    """
    return branches.switched(collection, scores, "branches", branches.AXES)
