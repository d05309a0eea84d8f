"""Figure 3.8: backbone curves

Amplitude of the probe against the instantaneous angular frequency during the test decay, by peak
finding and fitting. One seed of each method is drawn: the median one by decay NMTE. The frequency
axis is chosen by the full order; models that lie outside it are named above the panel. Of a
recorded decay the grey band holds each mean frequency with a confidence of 95 %.
"""

import numpy as np
from matplotlib.figure import Figure

from vibrom.report.collection import FULL_ORDER, answered, at_probe
from vibrom.report.drawing import layout, panels, style
from vibrom.report.drawing.response import THIN, TRUTH
from vibrom.report.plots import Panel, Series
from vibrom.thesis.labels import label

FAMILY = "models"
PLACE = 480
EACH = "run"
ASKED = "backbone"  # where that is asked only
DATA = ("backbone",)
X, Y = "angular frequency [rad/s]", "probe amplitude [m]"


def draw(collection, scores, scene=None) -> Figure:
    """A panel a scene."""
    figure, axes = layout.grid(max(1, len(collection.scenes)), least=2.4, height=1.35)
    handles, looks = {}, style.looks(collection.methods)
    for panel, name in zip(axes, collection.scenes):
        panel.set(title=name, xlabel=X, ylabel=Y)
        truth = collection.find(name, FULL_ORDER, "backbone")
        notes = [] if truth is not None else ["full order: not in this run"]
        if curve(truth)[0].size:
            line = panel.plot(*curve(truth), **TRUTH)[0]
            handles[label(FULL_ORDER)] = line
            known = collection.find(name, FULL_ORDER, "structure")
            if known is not None and "node" not in known:
                panel.fill_betweenx(*interval(truth), color="0.85", linewidth=0)
        low, high = limits(panel, *curve(truth))
        for index, (method, look) in enumerate(looks.items()):
            _, backbone = panels.drawn(collection, scores, name, method, "backbone")
            points = curve(backbone)
            inside = ((points[0] >= low) & (points[0] <= high)).any()
            if inside:
                look = look | {"markevery": (index, 9), **THIN}
                handles[label(method)] = panel.plot(*points, **look)[0]
            if text := panels.ending(backbone, "backbone") or ("" if inside else absent(*points)):
                notes.append(f"{label(method)}: {text}")
        if notes:
            layout.words(panel, "\n".join(notes))
    layout.legend(figure, handles.values(), handles)
    return figure


def curve(backbone) -> tuple[np.ndarray, np.ndarray]:
    """Frequency [rad/s] and amplitude [m] at the probe, without the padding."""
    if not answered(backbone):
        return np.array([]), np.array([])
    frequency, amplitude = (at_probe(backbone, name) for name in ("angular_frequency", "amplitude"))
    kept = np.isfinite(frequency) & np.isfinite(amplitude)
    return frequency[kept], amplitude[kept]


def interval(backbone) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Amplitude [m], and where the frequency [rad/s] is with a confidence of 95 %, from and to."""
    frequency, amplitude, sure = (
        at_probe(backbone, name)
        for name in ("angular_frequency", "amplitude", "angular_frequency_uncertainty")
    )
    order = np.argsort(amplitude)
    return amplitude[order], (frequency - sure)[order], (frequency + sure)[order]


def limits(panel, frequency: np.ndarray, amplitude: np.ndarray) -> tuple[float, float]:
    """Of the frequency [rad/s]: a model that is far off is named instead of squeezing all others
    together.
    """
    if not frequency.size:
        return -np.inf, np.inf
    sides = view(frequency, amplitude)
    panel.set_xlim(sides["x"])
    panel.set_ylim(sides["y"])
    panel.locator_params(axis="x", nbins=5)
    return sides["x"]


def absent(frequency: np.ndarray, amplitude: np.ndarray) -> str:
    """Why a model is not in the panel."""
    return f"outside, {np.median(frequency):.4g} rad/s" if frequency.size else "too few peaks"


def plot(collection, scores) -> list[Panel]:
    """Amplitude of the probe against the instantaneous frequency in the test decay; of each method
    the median seed. The full order chooses the frequencies: double-click shows all.
    """
    made = []
    for name in collection.scenes:
        truth, series, notes = collection.find(name, FULL_ORDER, "backbone"), [], []
        if curve(truth)[0].size:
            series.append(Series(FULL_ORDER, *curve(truth), mode="lines"))
        for method in collection.methods:
            seed, backbone = panels.drawn(collection, scores, name, method, "backbone")
            points = curve(backbone)
            if points[0].size:
                look = {"linewidth": 1.2, "markersize": 3}
                line = Series(method, *points, seed=seed, mode="lines+markers", look=look)
                series.append(line)
            if text := panels.ending(backbone, "backbone"):
                notes.append(f"{label(method)}: {text}.")
        made.append(Panel(name, X, Y, series, view=view(*curve(truth)), switch="y", notes=notes))
    return made


def view(frequency: np.ndarray, amplitude: np.ndarray) -> dict[str, tuple[float, float]]:
    """The range of both axes by the full order; the hardening is a few rad/s."""
    if not frequency.size:
        return {}
    width = max(np.ptp(frequency), 2e-3 * np.abs(frequency).mean())
    sides = float(frequency.min() - 1.2 * width), float(frequency.max() + 1.2 * width)
    return {"x": sides, "y": (0.0, 1.12 * float(amplitude.max()))}
