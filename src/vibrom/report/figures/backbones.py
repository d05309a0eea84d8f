"""Backbone curves: the amplitude at the probe against the frequency at which the decaying beam
swings (figure 3.8).
"""

import numpy as np
from matplotlib.figure import Figure

from vibrom.report.collection import FULL_ORDER, UNSEEDED, answered, probe_name
from vibrom.report.figures import panels, style
from vibrom.thesis import published as thesis


def curve(backbone) -> tuple[np.ndarray, np.ndarray]:
    """Frequency [rad/s] and amplitude [m] at the probe, without the padding."""
    if not answered(backbone):
        return np.array([]), np.array([])
    probe = [str(name) for name in backbone["probe"].values].index(probe_name(backbone))
    at_probe = backbone.transpose("probe", ...).isel(probe=probe)
    frequency, amplitude = at_probe["angular_frequency"].values, at_probe["amplitude"].values
    kept = np.isfinite(frequency) & np.isfinite(amplitude)
    return frequency[kept], amplitude[kept]


def draw(collection, scores, scene=None) -> Figure:
    figure, axes = panels.grid(
        max(1, len(collection.scenes)), columns=3, size=(3.3, 3.3), legend=0.6
    )
    handles = {}
    for panel, name in zip(axes, collection.scenes):
        panel.set(title=name, xlabel="angular frequency [rad/s]", ylabel="probe amplitude [m]")
        truth = collection.find(name, FULL_ORDER, "backbone", UNSEEDED)
        low, high = -np.inf, np.inf
        if curve(truth)[0].size:
            frequency, amplitude = curve(truth)
            handles[thesis.label(FULL_ORDER)] = panel.plot(
                frequency, amplitude, **style.FULL_ORDER
            )[0]
            # The hardening is a few rad/s: a model that is far off is named instead of squeezing
            # all others together.
            width = max(np.ptp(frequency), 2e-3 * np.abs(frequency).mean())
            low, high = frequency.min() - 1.2 * width, frequency.max() + 1.2 * width
            panel.set_xlim(low, high)
            panel.set_ylim(0, 1.12 * amplitude.max())
            panel.locator_params(axis="x", nbins=5)
        said = [] if truth is not None else ["full order: not in this run"]
        for index, method in enumerate(collection.methods):
            seed, backbone = panels.drawn(collection, scores, name, method, "backbone")
            points = curve(backbone)
            inside = (points[0] >= low) & (points[0] <= high)
            if inside.any():
                line = style.look(index, markevery=(index, 7), linewidth=0.9)
                handles[thesis.label(method)] = panel.plot(*points, **line)[0]
            text = panels.ending(backbone, "backbone")
            if not text and not inside.any():
                text = (
                    f"outside, {np.median(points[0]):.4g} rad/s"
                    if points[0].size
                    else "too few peaks"
                )
            if text:
                said.append(f"{thesis.label(method)}: {text}")
        if said:
            panels.words(panel, "\n".join(said), place="above")
    figure.legend(list(handles.values()), list(handles), loc="outside lower center", ncols=4)
    return figure
