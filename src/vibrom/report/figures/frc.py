"""Forced response curves at the probe: amplitude (figure 3.12), phase (figure 3.13); failed points
are counted.
"""

import numpy as np
from matplotlib.figure import Figure

from vibrom.report import curves
from vibrom.report.collection import FULL_ORDER, UNSEEDED, answered, at_probe, scalar
from vibrom.report.figures import panels, style
from vibrom.thesis import published as thesis


def amplitude(collection, scores, scene=None) -> Figure:
    return draw(collection, scores, "amplitude", "probe amplitude [m]")


def phase(collection, scores, scene=None) -> Figure:
    figure = draw(collection, scores, "phase", "phase of the probe [rad]")
    for panel in figure.axes:
        low = min(panel.dataLim.y0 if panel.lines else 0.0, -np.pi)
        lines = sum(text.get_text().count("\n") + 1 for text in panel.texts)
        ticks = {-2: r"$-2\pi$", -1.5: r"$-3\pi/2$", -1: r"$-\pi$", -0.5: r"$-\pi/2$", 0: "0"}
        panel.set_yticks([part * np.pi for part in ticks], list(ticks.values()))
        panel.set_ylim(low * (1.06 + 0.075 * lines), 0.25)
    return figure


def draw(collection, scores, quantity: str, axis: str) -> Figure:
    figure, axes = panels.grid(
        max(1, len(collection.scenes)), columns=3, size=(3.4, 3.5), legend=0.6
    )
    handles = {}
    for panel, scene in zip(axes, collection.scenes):
        truth = collection.find(scene, FULL_ORDER, "frc", UNSEEDED)
        forcing = float(scalar(truth, "forcing"))
        panel.set(title=f"{scene}, forcing {forcing:g}" if np.isfinite(forcing) else scene)
        panel.set(xlabel="forcing frequency [rad/s]", ylabel=axis)
        said = []
        for index, model in enumerate([FULL_ORDER, *collection.methods]):
            whole = model == FULL_ORDER
            _, curve = (
                (UNSEEDED, truth)
                if whole
                else panels.drawn(collection, scores, scene, model, "frc")
            )
            if curve is None:
                said.append(f"{thesis.label(model)}: not in this run")
                continue
            if not answered(curve):
                said.append(f"{thesis.label(model)}: {panels.ending(curve, 'response curve')}")
                continue
            values = at_probe(curve, quantity)
            line = (
                style.FULL_ORDER
                if whole
                else style.look(index - 1, markevery=(index % 3, 3), linewidth=0.9)
            )
            drawn = panel.plot(curve["angular_frequency"].values, values, **line)[0]
            handles.setdefault(thesis.label(model), drawn)
            if not np.isfinite(values).all():
                said.append(f"{thesis.label(model)}: {curves.finished(curve)}")
        if (
            truth is not None
            and np.isfinite(at_probe(truth, quantity)).any()
            and quantity == "amplitude"
        ):
            top = min(1.7 * float(np.nanmax(at_probe(truth, quantity))), panel.dataLim.y1)
            panel.set_ylim(-0.03 * top, top * (1.08 + 0.055 * len(said)))
        if said:
            panels.words(
                panel, "\n".join(said), place="left" if quantity == "amplitude" else "below"
            )
    figure.legend(list(handles.values()), list(handles), loc="outside lower center", ncols=4)
    return figure
