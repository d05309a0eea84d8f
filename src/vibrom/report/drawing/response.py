"""Forced response curves at the probe: a pair of panels a scene, the full order wide and pale under
the thin lines of the models, their differences below; failed points are counted.
"""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter

from vibrom.report import curves
from vibrom.report.collection import FULL_ORDER, Collection, answered, at_probe, scalar
from vibrom.report.drawing import layout, panels, style
from vibrom.report.plots import Panel, Series
from vibrom.report.scores import Scores
from vibrom.thesis.labels import label

FREQUENCY = "forcing frequency [rad/s]"
TRUTH = style.TRUE | {"linewidth": 3.4}
THIN = {"linewidth": 0.7, "markersize": 3.0, "markeredgewidth": 0.6}
SPARSE = 9  # points from one marker of a line to the next


def draw(
    collection: Collection, scores: Scores, quantity: str, axes: tuple[str, str]
) -> tuple[Figure, list[Axes]]:
    """One variable of all models, and below each panel what they differ by from the full order; and
    the upper panels. `axes`: what the upper and the lower ones show.
    """
    pairs, figure = grid(max(1, len(collection.scenes)))
    looks, handles = style.looks(collection.methods), {}
    for (upper, lower), scene in zip(pairs, collection.scenes):
        truth = collection.find(scene, FULL_ORDER, "frc")
        forcing = float(scalar(truth, "forcing"))
        upper.set_title(f"{scene}, forcing {forcing:g}" if np.isfinite(forcing) else scene)
        notes = note(truth, quantity, FULL_ORDER)
        if answered(truth):
            handles |= line(upper, truth, at_probe(truth, quantity), FULL_ORDER, TRUTH)
        for index, method in enumerate(collection.methods):
            _, curve = panels.drawn(collection, scores, scene, method, "frc")
            look = looks[method] | {"markevery": (index, SPARSE), **THIN}
            if answered(curve):
                values = at_probe(curve, quantity)
                handles |= line(upper, curve, values, method, look)
                line(lower, curve, difference(values, truth, quantity), method, look)
            notes += note(curve, quantity, method)
        if notes:
            layout.words(upper, "\n".join(notes))
    for upper, lower in pairs:
        upper.set(xlabel=FREQUENCY, ylabel=axes[0])
        lower.set(xlabel=FREQUENCY, ylabel=axes[1], yscale="log")
        lower.yaxis.set_major_locator(LogLocator(numticks=3))
        lower.yaxis.set_minor_formatter(NullFormatter())
    layout.legend(figure, handles.values(), handles)
    return figure, [upper for upper, _ in pairs]


def grid(count: int) -> tuple[list[tuple[Axes, Axes]], Figure]:
    """A pair of panels a scene, the upper one higher."""
    figure, axes = layout.grid(
        2 * count,
        least=layout.COLUMN,
        height=0.62,
        sharex=False,
        gridspec_kw={"height_ratios": (2, 1) * count},
    )
    pairs = list(zip(axes[::2], axes[1::2]))
    for upper, lower in pairs:
        lower.sharex(upper)
        upper.tick_params(labelbottom=False)
    return pairs, figure


def difference(values: np.ndarray, truth, quantity: str) -> np.ndarray:
    """Size of what a curve differs by: an amplitude in percent of the largest, a phase in rad."""
    known = at_probe(truth, quantity) if answered(truth) else np.full(1, np.nan)
    if known.shape != values.shape:
        return np.full(values.shape, np.nan)
    scale = 100 / np.nanmax(np.abs(known)) if quantity == "amplitude" else 1.0
    size = scale * np.abs(values - known)
    return np.where(size > 0, size, np.nan)


def line(panel: Axes, curve, values: np.ndarray, model: str, look: dict) -> dict:
    """The curve, by its label."""
    return {label(model): panel.plot(curve["angular_frequency"].values, values, **look)[0]}


def note(curve, quantity: str, model: str) -> list[str]:
    """Why a curve is missing, or has gaps."""
    if curve is None:
        return [f"{label(model)}: not in this run"]
    if not answered(curve):
        return [f"{label(model)}: {panels.ending(curve, 'response curve')}"]
    whole = np.isfinite(at_probe(curve, quantity)).all()
    return [] if whole else [f"{label(model)}: {curves.finished(curve)}"]


def plot(collection: Collection, scores: Scores, quantity: str, axis: str) -> list[Panel]:
    """A panel a scene with all seeds; those that figures do not draw are faint."""
    made = []
    for scene in collection.scenes:
        truth, series, notes = collection.find(scene, FULL_ORDER, "frc"), [], []
        if answered(truth):
            omega = truth["angular_frequency"].values
            series.append(Series(FULL_ORDER, omega, at_probe(truth, quantity)))
            notes += note(truth, quantity, FULL_ORDER)
        for method in collection.methods:
            chosen, curve = panels.drawn(collection, scores, scene, method, "frc")
            for seed in collection.seeds(scene, method):
                if answered(found := collection.find(scene, method, "frc", seed)):
                    line = {"seed": seed, "faint": seed != chosen}
                    line |= {"notes": curves.outcomes(found, found.sizes["angular_frequency"])}
                    line |= {"look": {"linewidth": 1.2, "markersize": 3}, "mode": "lines+markers"}
                    x, y = found["angular_frequency"].values, at_probe(found, quantity)
                    series.append(Series(method, x, y, **line))
            notes += note(curve, quantity, method)
        forcing = float(scalar(truth, "forcing"))
        title = f"{scene}, forcing {forcing:g}" if np.isfinite(forcing) else scene
        view = bounds(truth, quantity)
        words = {"switch": "y", "notes": [f"{text}." for text in notes], "view": view}
        made.append(Panel(title, FREQUENCY, axis, series, **words))
    return made


def bounds(truth, quantity: str) -> dict[str, tuple[float, float]]:
    """The vertical range by the full order, so that a blow-up does not flatten it."""
    known = at_probe(truth, quantity) if answered(truth) else np.zeros(0)
    if not np.isfinite(known).any():
        return {}
    low, high = float(np.nanmin(known)), float(np.nanmax(known))
    return {"y": (low - 0.1 * (high - low), high + 0.25 * (high - low))}
