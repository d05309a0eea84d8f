"""Energy of decays from random states

Mechanical energy of the decoded motion over that at rest, mean over each period, of runs released
up to the given distance beyond the training range. The structure's damping is positive: the
energy of a model that has learnt it falls. A line a release and guard, of the median seed.
"""

import numpy as np
from matplotlib.figure import Figure

from vibrom.report import robustness
from vibrom.report.columns import number
from vibrom.report.drawing import layout, panels, style
from vibrom.thesis.labels import label

FAMILY = "robustness"
PLACE = 820
EACH = "scene"
DATA = ("guards",)


def draw(collection, scores, scene) -> Figure:
    """A panel a method."""
    found = {
        method: panels.drawn(collection, scores, scene, method, "robustness")
        for method in collection.methods
    }
    found = {method: drawn for method, drawn in found.items() if drawn[1] is not None}
    figure, axes = layout.grid(max(1, len(found)), height=0.85)
    handles: dict = {}
    for panel, (method, (seed, answer)) in zip(axes, found.items()):
        for place, guard in enumerate(answer["guard"].values):
            line = decays(panel, answer.isel(integrator=0).sel(guard=guard), place)
            handles.setdefault(str(guard), line)
        panel.set(title=panels.title(method, seed))
    for panel in axes:
        panel.set(xlabel="time after release [periods]", ylabel="energy [J]")
    if handles:
        layout.legend(figure, handles.values(), handles)
    else:
        layout.words(axes[0], "no robustness tests in this run")
    return figure


def seen(collection, scores, scene) -> str:
    """What is left of the energy at the end of the runs that lasted, by guard."""
    parts = []
    for method in collection.methods:
        _, answer = panels.drawn(collection, scores, scene, method, "robustness")
        if answer is None:
            continue
        for guard in answer["guard"].values:
            energy = answer.isel(integrator=0).sel(guard=guard)["energy"].values
            lasted = energy[np.isfinite(energy[:, -1])]
            left = number(float(lasted[:, -1].max()), 2) if len(lasted) else "no"
            lasting = f"{len(lasted)} of {len(energy)} lasted, at most {left} J left"
            parts.append(f"{label(method)}, {guard}: {lasting}.")
    return " ".join(parts) or "No robustness tests in this run."


def decays(panel, answer, place: int):
    """With one guard; how many failed stands in the panel."""
    energy = answer["energy"].values
    look = style.look(place, marker="", linewidth=0.7)
    periods, positive = np.arange(1, energy.shape[1] + 1), np.where(energy > 0, energy, np.nan)
    line = panel.semilogy(periods, positive.T, **look)[0]
    gone = int((~np.isfinite(energy[:, -1])).sum())
    if gone and robustness.evaluated(answer):
        text = f"{answer['guard'].item()}: {gone} of {len(energy)} decays failed"
        layout.words(panel, text)
    return line
