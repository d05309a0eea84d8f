"""A panel for each model, with the full order's response curve behind it."""

from collections.abc import Callable
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from vibrom.models.curves import Curve
from vibrom.report.branches import curve, scenes
from vibrom.report.collection import FULL_ORDER, Collection
from vibrom.report.drawing import layout, panels
from vibrom.report.plots import Panel, Series
from vibrom.report.scores import Scores

STABLE, UNSTABLE = {"linestyle": "-"}, {"linestyle": (0, (1.2, 1.2))}
BEHIND = {"color": "0.72", "linewidth": 2.2}
AROUND = 6.0  # times the distance of the folds: how much of the curve is shown beside them
FRONT = {"color": "#8a2a0b", "linewidth": 0.9}
AXES = ("forcing frequency [rad/s]", "probe amplitude [m]")
S_AXES = ("forcing, times the load [–]", AXES[1])


def draw(
    collection: Collection,
    scores: Scores,
    scene: str,
    name: str,
    show: Callable[[Any, Collection, str, str, int | None], None],
    full_order: bool = False,
    whole: str = "branches",
) -> Figure:
    """`show` fills the panel of a model and its median seed; `name` is what it shows, and `whole`
    what stands behind it.
    """
    first = [FULL_ORDER] if full_order else []
    asked = scene in scenes(collection, name)
    models = [*first, *collection.methods] if asked else []
    figure, axes = layout.grid(max(1, len(models)), height=0.7)
    for panel in axes:
        panel.set(xlabel=(S_AXES if whole == "s_curve" else AXES)[0], ylabel=AXES[1])
    for panel, model in zip(axes, models):
        seed, answer = panels.drawn(collection, scores, scene, model, name)
        panel.set_title(panels.title(model, seed))
        behind(panel, curve(collection.find(scene, FULL_ORDER, whole)))
        if answer is None:
            layout.words(panel, f"no {name} in this run")
        else:
            show(panel, collection, scene, model, seed)
    if not models:
        layout.words(axes[0], f"no {name} in this run")
    layout.heading(figure, scene)
    layout.legend(figure, *layout.of_panels(figure))
    return figure


def behind(panel, found: Curve | None) -> None:
    """The full order's curve, which chooses the axes: the neighbourhood of its folds, if it has
    any.
    """
    if found is not None:
        line(panel, found, BEHIND, "full order")
        sides = view(found)
        panel.set(xlim=sides["x"], ylim=sides["y"])


def view(found: Curve | None) -> dict[str, tuple[float, float]]:
    """The range of both axes that shows the full order's folds; empty without a curve."""
    if found is None:
        return {}
    low, high = found.parameter.min(), found.parameter.max()
    if len(found.folds):
        first, last = found.parameter[found.folds].min(), found.parameter[found.folds].max()
        low = max(low, first - AROUND * (last - first))
        high = min(high, last + AROUND * (last - first))
    top = float(found.amplitude.max())
    return {"x": (float(low), float(high)), "y": (-0.03 * top, 1.3 * top)}


def line(panel, found: Curve, look: dict, words: str) -> None:
    """Stable parts drawn through, unstable ones dotted; each part keeps one point of the next."""
    for number in np.unique(found.branch):
        branch = found.part(found.branch == number)
        (changes,) = np.nonzero(branch.stable[1:] != branch.stable[:-1])
        cuts = [0, *(changes + 1), len(branch.stable)]
        for first, last in zip(cuts, cuts[1:]):
            stable = bool(branch.stable[first])
            part = slice(max(first - 1, 0), last)
            panel.plot(
                branch.parameter[part],
                branch.amplitude[part],
                **look,
                **(STABLE if stable else UNSTABLE),
                label=f"{words}, {'stable' if stable else 'unstable'}",
            )


def marked(panel, found: Curve | None) -> None:
    """A model's curve, its main folds marked."""
    if found is None:
        layout.words(panel, "no motion was found")
        return
    line(panel, found, FRONT, "model")
    folds = found.folds
    panel.plot(
        found.parameter[folds],
        found.amplitude[folds],
        "o",
        color=FRONT["color"],
        markersize=2.6,
        label="main fold of the model",
    )


def switched(
    collection: Collection, scores: Scores, name: str, axes: tuple[str, str]
) -> list[Panel]:
    """A panel a scene for the page: every model's curve, of each method the median seed."""
    made = []
    for scene in scenes(collection, name):
        series = []
        for model in (FULL_ORDER, *collection.methods):
            seed, answer = panels.drawn(collection, scores, scene, model, name)
            if (found := curve(answer)) is not None:
                series += parts(model, None if model == FULL_ORDER else seed, found)
        sides = view(curve(collection.find(scene, FULL_ORDER, name)))
        made.append(Panel(scene, *axes, series, switch="y", view=sides))
    return made


def parts(model: str, seed: int | None, found: Curve) -> list[Series]:
    """The stable and the unstable motions; each part keeps one point of the next, and branches do
    not touch.
    """
    made, wide = [], 3.0 if model == FULL_ORDER else 1.2
    starts = np.flatnonzero(np.diff(found.branch)) + 1
    varies, kind = (
        np.insert(values, starts, fill)
        for values, fill in ((found.parameter, np.nan), (found.kind.astype(object), ""))
    )
    for stable, dashes in ((True, STABLE), (False, UNSTABLE)):
        mine = found.stable == stable
        beside = np.zeros_like(mine)
        joined = found.branch[1:] == found.branch[:-1]
        beside[1:] |= mine[:-1] & joined
        amplitude = np.where(mine | beside, found.amplitude, np.nan)
        line = {"name": "stable" if stable else "unstable", "notes": [str(word) for word in kind]}
        look = {**dashes, "linewidth": wide}
        series = Series(
            model, varies, np.insert(amplitude, starts, np.nan), seed, look=look, **line
        )
        made.append(series)
    return made
