"""Figure 2.1: configurations of the beam

All states from which the beam is released, drawn to scale and coloured by the size of the
displacement; the number is the displacement of the probe. Dashed: the beam at rest. A beam whose
end points backwards folds over itself.
"""

import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure

from vibrom.report.drawing import body, layout
from vibrom.report.drawing.states import states

FAMILY = "models"
PLACE = 420
EACH = "run"
RECORDED = False  # of scenes with a body only
DATA = ("beam", "{scene}/full_order/release.nc")


def draw(collection, scores, scene=None) -> Figure:
    """All states over one another."""
    figure, (axes,) = layout.grid(1, height=2.2)
    found = states(collection)
    axes.set(**body.labels(found[0].structure if found else None), aspect="equal")
    if not found:
        layout.words(axes, "no release states in this run")
        return figure
    largest = max(body.magnitude(state.structure, state.displacement).max() for state in found)
    rest = found[0].structure
    for loop in body.outlines(rest, np.zeros(rest.sizes["dof"])):
        axes.plot(*loop.T, color="0.5", linewidth=0.7, linestyle=(0, (4, 2)), zorder=1)
    for state in found:
        corners, order = body.polygons(state.structure, state.displacement)
        cells = PolyCollection(
            list(corners),
            array=body.magnitude(state.structure, state.displacement)[order],
            clim=(0, largest),
            cmap="viridis",
            linewidth=0.15,
            edgecolor="face",
        )
        axes.add_collection(cells)
        moved = body.displacement(state.structure, state.displacement)
        free_end = np.argmax(np.linalg.norm(moved, axis=1))
        place = body.view(state.structure) @ (body.rest(state.structure) + moved)[free_end]
        layout.name(axes, f"{next(iter(state.shown.values())):.4g} m", place)
    axes.autoscale_view()
    axes.margins(x=0.12, y=0.08)
    bar = figure.colorbar(cells, ax=axes, location="bottom", shrink=0.8)
    bar.set_label("size of the displacement [m]")
    return figure


def seen(collection, scores, scene=None) -> str:
    """The displacement of each state."""
    found = [f"{next(iter(state.shown.values())):.4g} m" for state in states(collection)]
    if not found:
        return "No release states in this run."
    return f"{len(found)} states, with the probe at {', '.join(found)}."
