"""Sweeps up and down

Largest displacement of the probe in the last period at each frequency of a sweep, the motion
carried on from one frequency to the next: upward triangles as the frequency rises, downward ones
as it falls. Where the curve folds, a sweep stays on its branch to the end, and jumps. Behind stands
the full order's curve with all its branches: stable motions drawn through, unstable ones dotted.
The first panel of each case is the full order itself. One seed of each method is drawn: the median
one by decay NMTE.
"""

import numpy as np
from matplotlib.figure import Figure

from vibrom.report.branches import curve, scenes
from vibrom.report.collection import FULL_ORDER, answered, at_probe
from vibrom.report.drawing import branches, layout, panels
from vibrom.report.plots import Panel, Series

FAMILY = "models"
PLACE = 565
EACH = "scene"
DATA = ("folds",)
ASKED = "sweeps"  # where that is asked only
LOOKS = {
    "up": {"marker": "^", "color": "#0072b2"},
    "down": {"marker": "v", "color": "#d55e00"},
}


def draw(collection, scores, scene) -> Figure:
    """A panel a model, the full order first."""
    return branches.draw(collection, scores, scene, "sweeps", show, full_order=True)


def show(panel, collection, scene, model, seed) -> None:
    """Both directions."""
    swept = collection.find(scene, model, "sweeps", seed)
    if not answered(swept):
        layout.words(panel, panels.ending(swept, "sweeps"))
        return
    frequency, amplitude = swept["angular_frequency"].values, at_probe(swept, "amplitude")
    for direction, values in zip(swept["direction"].values, amplitude):
        look = LOOKS[str(direction)]
        panel.plot(
            frequency,
            values,
            linestyle="none",
            markersize=3.2,
            markerfacecolor="none",
            label=f"sweep {direction}",
            **look,
        )
    inside = np.isfinite(amplitude).any()
    if not inside:
        layout.words(panel, "no motion lasted")
    panel.set_xlim(frequency.min(), frequency.max())


def plot(collection, scores) -> list[Panel]:
    """Upward triangles as the frequency rises, downward ones as it falls, the motion carried on
    from one frequency to the next; behind them the full order's curve with all its branches. Of
    each method the median seed.
    """
    made = []
    for scene in scenes(collection, "sweeps"):
        found = curve(collection.find(scene, FULL_ORDER, "branches"))
        series = [] if found is None else branches.parts(FULL_ORDER, None, found)
        for model in (FULL_ORDER, *collection.methods):
            seed, swept = panels.drawn(collection, scores, scene, model, "sweeps")
            if answered(swept):
                for direction, values in zip(
                    swept["direction"].values, at_probe(swept, "amplitude")
                ):
                    look = {"marker": LOOKS[str(direction)]["marker"], "markersize": 4}
                    line = {"name": f"sweep {direction}", "mode": "markers", "look": look}
                    frequency = swept["angular_frequency"].values
                    whose = None if model == FULL_ORDER else seed
                    series.append(Series(model, frequency, values, whose, **line))
        made.append(Panel(scene, *branches.AXES, series, switch="y"))
    return made
