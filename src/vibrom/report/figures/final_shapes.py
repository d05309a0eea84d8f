"""Figure 3.10: largest shapes under forcing

The shape of the beam at the largest probe displacement of the last forced period: full order
filled, reduced model as an outline. Displacements that are too small to see are magnified by the
factor in the heading. One seed is drawn, named in the title: the median one by decay NMTE. A
model that failed says so.
"""

import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure

from vibrom.report.collection import FULL_ORDER, answered, scalar
from vibrom.report.columns import number
from vibrom.report.drawing import body, layout, panels
from vibrom.thesis.labels import label

FAMILY = "models"
PLACE = 500
EACH = "scene"
ASKED = "forced"  # where that is asked only
DATA = ("forced",)

LEAST, WIDTH = 1.15, 0.72  # [inches] of a panel with its labels, and without


def draw(collection, scores, scene) -> Figure:
    """A panel a method."""
    block = Block(collection, scores, scene, collection.methods)
    figure, axes = layout.grid(
        max(1, len(block.runs)), least=LEAST, height=block.height, sharex=True, sharey=True
    )
    layout.heading(figure, block.heading)
    for panel in axes:
        xlim, ylim = block.limits
        panel.set(**body.labels(block.structure), aspect="equal", xlim=xlim, ylim=ylim)
        panel.tick_params(labelbottom=True)
    for panel, method, (seed, run) in zip(axes, collection.methods, block.runs):
        panel.set_title(panels.title(method, seed))
        block.shapes(panel, run)
        if text := panels.ending(run, "forced run"):
            layout.words(panel, text)
    return figure


def seen(collection, scores, scene) -> str:
    """How far each model's shape lies from the full order's."""
    parts = []
    block = Block(collection, scores, scene, collection.methods)
    for method, (_, run) in zip(collection.methods, block.runs):
        if text := panels.ending(run, "forced run"):
            parts.append(f"{label(method)}: {text}.")
        elif block.truth is not None:
            off = np.linalg.norm(run["final_shape"].values - block.truth)
            percent = 100.0 * off / np.linalg.norm(block.truth)
            parts.append(f"{label(method)}: {number(percent, 2)} % from the full order.")
    return " ".join(parts)


class Block:
    """One case: its runs, the magnification of its displacements, and limits [m] that hold every
    shape.
    """

    def __init__(self, collection, scores, scene: str, methods: list[str]):
        self.structure = collection.mesh(scene)
        self.runs = [
            panels.drawn(collection, scores, scene, method, "forced") for method in methods
        ]
        found = [run for _, run in self.runs if answered(run)]
        self.truth = next(
            (shape for run in found if np.isfinite(shape := run["final_shape_true"].values).all()),
            None,
        )
        known = self.truth is not None and self.structure is not None
        self.factor = body.magnification(self.structure, self.truth) if known else 1.0
        forcing = float(scalar(collection.find(scene, FULL_ORDER, "forced"), "forcing"))
        magnified = f", displacement drawn {self.factor:g} times" if self.factor != 1 else ""
        self.heading = f"{scene}, forcing {forcing:g}{magnified}"
        self.limits = ((0.0, 1.0), (0.0, 1.0))
        if self.structure is not None:
            shapes = [
                np.zeros(self.structure.sizes["dof"]),
                *(run["final_shape"].values for run in found),
            ]
            shapes = [
                shape
                for shape in [*shapes, self.truth]
                if shape is not None and np.isfinite(shape).all()
            ]
            loops = [
                loop for free in shapes for loop in body.outlines(self.structure, free, self.factor)
            ]
            points = np.concatenate(loops)
            side = body.longest_side(self.structure)
            # A shape beyond a few lengths is wrong anyway, and must not shrink the others.
            low, high = (
                np.clip(edge, -2.5 * side, 2.5 * side)
                for edge in (points.min(axis=0), points.max(axis=0))
            )
            self.limits = tuple(
                (float(low[axis] - 0.05 * side), float(high[axis] + 0.05 * side)) for axis in (0, 1)
            )

    @property
    def height(self) -> float:
        """[inches] of a panel, by the aspect of the limits."""
        (left, right), (bottom, top) = self.limits
        return min(1.3, max(0.3, WIDTH * (top - bottom) / (right - left)))

    def shapes(self, panel, run) -> None:
        """The full order filled, the model as an outline; a model that failed leaves the full order
        alone.
        """
        if self.structure is None:
            return
        for loop in body.outlines(self.structure, np.zeros(self.structure.sizes["dof"])):
            panel.plot(*loop.T, color="0.5", linewidth=0.6, linestyle=(0, (4, 2)))
        if self.truth is not None:
            cells, _ = body.polygons(self.structure, self.truth, self.factor)
            panel.add_collection(
                PolyCollection(list(cells), facecolor="0.72", edgecolor="0.72", linewidth=0.3)
            )
        if answered(run) and np.isfinite(run["final_shape"].values).all():
            for loop in body.outlines(self.structure, run["final_shape"].values, self.factor):
                panel.plot(*loop.T, color="#8a2a0b", linewidth=0.8)
