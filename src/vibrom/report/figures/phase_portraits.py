"""Figure 3.4: the decay in reduced coordinates

Wide and pale: the test trajectory mapped into the reduced coordinates of each model. Thin and
dashed: what the model makes of it from the same start. The axes are chosen by the true
trajectory. One seed is drawn, named in the title: the median one by decay NMTE. The thesis shows
the case large.
"""

import numpy as np
from matplotlib.figure import Figure

from vibrom.report.collection import answered
from vibrom.report.drawing import layout, panels, style
from vibrom.report.plots import Panel, Series
from vibrom.thesis.labels import label

FAMILY = "models"
PLACE = 460
EACH = "scene"
ASKED = "decay"  # where that is asked only
RELATIVE = "z over its largest in the truth [–]", "dz/dt over its largest [–]"  # on the page
DATA = ("decay",)


def draw(collection, scores, scene) -> Figure:
    """A panel a method."""
    figure, axes = layout.grid(max(1, len(collection.methods)))
    layout.heading(figure, scene)
    for panel, method in zip(axes, collection.methods):
        seed, decay = panels.drawn(collection, scores, scene, method, "decay")
        panel.set(title=panels.title(method, seed), xlabel="$z$ [–]", ylabel=r"$\dot z$ [1/s]")
        if answered(decay):
            portrait(panel, decay)
        if text := panels.ending(decay, "decay"):
            layout.words(panel, text)
    layout.legend(figure, *layout.of_panels(figure))
    return figure


def portrait(panel, decay) -> None:
    """The encoded truth wide and pale, the model's own path thin and dashed."""
    size = decay.sizes["coordinate"]
    pair = [0, size // 2] if size > 1 else [0, 0]
    true, predicted = (
        decay[name].transpose("coordinate", "time").values[pair] for name in ("encoded", "reduced")
    )
    panel.plot(
        *panels.thinned(*true, limit=2000),
        **style.TRUE | {"linewidth": 1.5},
        label="true trajectory, encoded",
    )
    fine = style.PREDICTED | {"linewidth": 0.45, "linestyle": "-"}
    panel.plot(*panels.thinned(*predicted, limit=2000), **fine, label="predicted by the model")
    given = "coordinate_units" in decay.variables
    units = (
        [str(unit) for unit in decay["coordinate_units"].values[pair]] if given else ["–", "1/s"]
    )
    names = (
        (f"$z_{{{pair[0] + 1}}}$", f"$z_{{{pair[1] + 1}}}$") if size != 2 else ("$z$", r"$\dot z$")
    )
    panel.set(xlabel=f"{names[0]} [{units[0]}]", ylabel=f"{names[1]} [{units[1]}]")
    if np.isfinite(true).any():
        panel.set_xlim(*padded(true[0]))
        panel.set_ylim(*padded(true[1]))
        panel.locator_params(nbins=5)


def padded(values: np.ndarray) -> tuple[float, float]:
    """Limits from the truth, so that a model that ran away does not hide it."""
    largest = 1.35 * max(float(np.nanmax(np.abs(values))), 1e-300)
    return -largest, largest


def plot(collection, scores) -> list[Panel]:
    """Each model's path in its own reduced coordinates, position and velocity over the largest of
    the encoded truth: a model without error ends where the others do. Of each method the median
    seed.
    """
    made = []
    for scene in collection.scenes:
        series, notes = [], []
        for method in collection.methods:
            seed, decay = panels.drawn(collection, scores, scene, method, "decay")
            if answered(decay):
                pair = [0, decay.sizes["coordinate"] // 2]
                true, predicted = (
                    decay[name].transpose("coordinate", "time").values[pair]
                    for name in ("encoded", "reduced")
                )
                largest = np.nanmax(np.abs(true), axis=1, keepdims=True)
                path = panels.thinned(*(predicted / largest), limit=600)
                series.append(Series(method, *path, seed=seed, look={"linewidth": 1.0}))
            if text := panels.ending(decay, "decay"):
                notes.append(f"{label(method)}: {text}.")
        words = {"view": {"x": (-1.2, 1.2), "y": (-1.2, 1.2)}, "notes": notes}
        made.append(Panel(scene, *RELATIVE, series, **words))
    return made
