"""Backbones at phase resonance

Where the displacement along the load lags it by a quarter of a period, the load does nothing but
replace what damping takes. Left: largest displacement of the probe in a period against the
frequency of these motions, the backbone of the forced response. Right: their damping ratio against
that displacement. One seed of each method is drawn: the median one by decay NMTE. The full order
chooses the axes.
"""

import numpy as np
from matplotlib.figure import Figure

from vibrom.report.branches import scenes
from vibrom.report.collection import FULL_ORDER, answered, at_probe
from vibrom.report.drawing import layout, panels, style
from vibrom.report.drawing.response import THIN, TRUTH
from vibrom.report.plots import Panel, Series
from vibrom.thesis.labels import label

FAMILY = "models"
PLACE = 568
EACH = "run"
DATA = ("resonance",)
ASKED = "resonance"  # where that is asked only
X, Y, Z = "angular frequency [rad/s]", "probe amplitude [m]", "damping ratio [–]"


def draw(collection, scores, scene=None) -> Figure:
    """Two panels a scene."""
    shown = scenes(collection, "resonance")
    figure, axes = layout.grid(max(1, 2 * len(shown)), least=layout.COLUMN, height=1.5)
    handles, looks = {}, style.looks(collection.methods)
    for name, left, right in zip(shown, axes[::2], axes[1::2]):
        left.set(title=name, xlabel=X, ylabel=Y)
        right.set(title=name, xlabel=Y, ylabel=Z)
        truth = curves(collection.find(name, FULL_ORDER, "resonance"))
        for panel, points in zip((left, right), truth):
            handles[label(FULL_ORDER)] = panel.plot(*points, **TRUTH)[0]
        for index, (method, look) in enumerate(looks.items()):
            _, answer = panels.drawn(collection, scores, name, method, "resonance")
            look = look | {"markevery": (index % 4, 4), **THIN}
            for panel, points in zip((left, right), curves(answer)):
                handles[label(method)] = panel.plot(*points, **look)[0]
        for panel, points in zip((left, right), truth):
            sides = view(*points)
            panel.set(xlim=sides.get("x"), ylim=sides.get("y"))
    if not shown:
        layout.words(axes[0], "no resonance in this run")
    if handles:
        layout.legend(figure, handles.values(), handles)
    return figure


def curves(answer) -> tuple[tuple[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]:
    """(frequency, amplitude) and (amplitude, damping ratio) of the probe."""
    if not answered(answer):
        nothing = np.array([])
        return (nothing, nothing), (nothing, nothing)
    amplitude = at_probe(answer, "amplitude")
    known = np.isfinite(amplitude)
    frequency, damping = (answer[name].values for name in ("angular_frequency", "damping_ratio"))
    return (frequency[known], amplitude[known]), (amplitude[known], damping[known])


def view(x: np.ndarray, y: np.ndarray) -> dict[str, tuple[float, float]]:
    """The range of both axes, with some room."""
    if not x.size:
        return {}
    room = [max(0.15 * np.ptp(part), 2e-3 * np.abs(part).max()) for part in (x, y)]
    sides = [(float(part.min() - r), float(part.max() + r)) for part, r in zip((x, y), room)]
    return dict(zip("xy", sides))


def plot(collection, scores) -> list[Panel]:
    """Largest displacement of the probe in a period against the frequency at phase resonance, and
    the damping ratio against that displacement; of each method the median seed.
    """
    made = []
    for name in scenes(collection, "resonance"):
        truth = curves(collection.find(name, FULL_ORDER, "resonance"))
        for side, axes in enumerate(((X, Y), (Y, Z))):
            series = [Series(FULL_ORDER, *truth[side], mode="lines")]
            for method in collection.methods:
                seed, answer = panels.drawn(collection, scores, name, method, "resonance")
                points = curves(answer)[side]
                if points[0].size:
                    look = {"linewidth": 1.2, "markersize": 3}
                    line = Series(method, *points, seed=seed, mode="lines+markers", look=look)
                    series.append(line)
            made.append(Panel(name, *axes, series, view=view(*truth[side]), switch="y"))
    return made
