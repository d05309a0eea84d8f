"""Figure 3.1: release states

Each state that training and test decays start from, with the displacement of the probe and, where
the scene has one, of the tip, and the cases that use it. Each is the displacement at one step of a
run forced from rest; velocity and acceleration are then set to zero. Dashed: the beam at rest. What
the thesis prints as the tip's displacement is the probe's.
"""

import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure

from vibrom.report.drawing import body, layout
from vibrom.report.drawing.states import states

FAMILY = "models"
PLACE = 430
EACH = "run"
RECORDED = False  # of scenes with a body only
DATA = ("{scene}/full_order/release.nc",)


def draw(collection, scores, scene=None) -> Figure:
    """A panel a state."""
    found = states(collection)
    figure, axes = layout.grid(max(1, len(found)), height=0.75, sharex=True, sharey=True)
    for panel in axes:
        panel.set(**body.labels(found[0].structure if found else None), aspect="equal")
        panel.tick_params(labelbottom=True, labelleft=True)
    if not found:
        layout.words(axes[0], "no release states in this run")
    for panel, state in zip(axes, found):
        for loop in body.outlines(state.structure, np.zeros(state.structure.sizes["dof"])):
            panel.plot(*loop.T, color="0.5", linewidth=0.7, linestyle=(0, (4, 2)))
        cells = list(body.polygons(state.structure, state.displacement)[0])
        panel.add_collection(
            PolyCollection(cells, facecolor="0.55", edgecolor="black", linewidth=0.15)
        )
        panel.set_title("\n".join(f"{name} {value:.4f} m" for name, value in state.shown.items()))
        layout.words(panel, ", ".join(state.used))
        panel.autoscale_view()
    return figure


def seen(collection, scores, scene=None) -> str:
    """The displacement of each state, and who uses it."""
    found = []
    for state in states(collection):
        shown = ", ".join(f"{name} at {value:.4f} m" for name, value in state.shown.items())
        found.append(f"{' and '.join(state.used)}: {shown}.")
    return " ".join(found) or "No release states in this run."
