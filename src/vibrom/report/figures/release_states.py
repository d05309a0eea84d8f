"""Each release state on its own, with its displacements and the scenes that use it (figure 3.1)."""

import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure

from vibrom.report.figures import body, panels
from vibrom.report.figures.states import states


def draw(collection, scores, scene=None) -> Figure:
    found = states(collection)
    figure, axes = panels.grid(
        max(1, len(found)), columns=3, size=(3.0, 2.5), sharex=True, sharey=True
    )
    for panel in axes:
        panel.set(xlabel="x [m]", ylabel="y [m]", aspect="equal")
        panel.tick_params(labelbottom=True, labelleft=True)
    if not found:
        panels.words(axes[0], "no release states in this run")
    for panel, state in zip(axes, found):
        for loop in body.outlines(state.structure, np.zeros(state.structure.sizes["dof"])):
            panel.plot(*loop.T, color="0.5", linewidth=0.7, linestyle=(0, (4, 2)))
        cells = list(body.quadrilaterals(state.structure, state.displacement))
        panel.add_collection(
            PolyCollection(cells, facecolor="0.55", edgecolor="black", linewidth=0.15)
        )
        panel.set_title(f"probe {state.at('probe'):.4f} m, tip {state.at('tip'):.4f} m")
        panels.words(panel, "\n".join(state.used), place="above")
        panel.autoscale_view()
    return figure
