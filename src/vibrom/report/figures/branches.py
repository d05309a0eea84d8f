"""Response curves with all their branches

Largest displacement of the probe in a period of every periodic motion that was found, against the
forcing frequency: stable motions drawn through, unstable ones dotted, main folds marked. Behind
each model stands the full order. One seed of each method is drawn: the median one by decay NMTE.
The axes are chosen by the full order.
"""

from matplotlib.figure import Figure

from vibrom.report.branches import curve
from vibrom.report.drawing import branches, panels

FAMILY = "models"
PLACE = 560
EACH = "run"
DATA = ("folds",)
GLANCE = True


def draw(collection, scores, scene=None) -> Figure:
    """A panel a scene and model."""
    figure = branches.draw(collection, scores, "branches", show)
    branches.legend(figure)
    return figure


def show(panel, collection, scene, model, seed) -> None:
    """The model's curve on the full order's."""
    found = curve(collection.find(scene, model, "branches", seed))
    if found is None:
        panels.words(panel, "no motion was found")
        return
    branches.line(panel, found, branches.FRONT, "model")
    folds = found.folds
    panel.plot(
        found.frequency[folds],
        found.amplitude[folds],
        "o",
        color=branches.FRONT["color"],
        markersize=2.6,
        label="main fold of the model",
    )
