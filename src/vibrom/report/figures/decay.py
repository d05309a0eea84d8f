"""Figures 3.5 to 3.7: the predicted decay

Displacement of the probe (x = 0.525 m, bottom edge) in the test decay: full order (wide, pale)
and each reduced model (thin, dashed), with the NMTE over all displacements in the title. One seed
is drawn, named in the title: the median one by decay NMTE. The vertical axis is chosen by the
full order. A model that failed or left its training range says so in its panel.
"""

import numpy as np
from matplotlib.figure import Figure

from vibrom.report.collection import FULL_ORDER, answered, at_probe
from vibrom.report.drawing import panels, style
from vibrom.report.plots import Panel, Series
from vibrom.thesis.labels import label

FAMILY = "models"
PLACE = 470
EACH = "scene"
DATA = ("decay",)
POINTS, LAST = 1500, 5  # of a line on the page; periods that it shows at first


def draw(collection, scores, scene) -> Figure:
    """A panel a method."""
    figure, axes = panels.grid(
        max(1, len(collection.methods)), columns=2, size=(4.4, 1.65), legend=0.45, sharex=True
    )
    figure.suptitle(scene, fontsize=8, x=0.01, ha="left", style="italic")
    for panel, method in zip(axes, collection.methods):
        seed, decay = panels.drawn(collection, scores, scene, method, "decay")
        panel.set(
            title=panels.title(
                method, seed, scores.value(scene, method, seed, "decay", "nmte_percent")
            ),
            xlabel="time [s]",
            ylabel="probe [m]",
        )
        panel.tick_params(labelbottom=True)
        if answered(decay):
            true, predicted = at_probe(decay, "probe_true"), at_probe(decay, "probe_displacement")
            time, true, predicted = panels.thinned(
                decay["time"].values, true, predicted, limit=1500
            )
            panel.plot(time, true, **style.TRUE | {"linewidth": 1.6}, label="full order")
            panel.plot(time, predicted, **style.PREDICTED, label="reduced model")
            panels.breathe(panel, true)
        if text := panels.ending(decay, "decay"):
            panels.words(panel, text, place="above")
    handles = next((panel.get_legend_handles_labels() for panel in axes if panel.lines), ([], []))
    figure.legend(*handles, loc="outside lower center", ncols=2)
    return figure


def plot(collection, scores) -> list[Panel]:
    """Displacement of the probe in the last periods of the test decay, where errors of the
    frequency have added up; double-click shows all of it. Of each method the median seed.
    """
    made = []
    for name in collection.scenes:
        truth, series, notes, view = collection.find(name, FULL_ORDER, "test"), [], [], {}
        if truth is not None:
            motion = at_probe(truth, "probe_displacement")
            time, motion = panels.thinned(truth["time"].values, motion, limit=POINTS)
            series.append(Series(FULL_ORDER, time - time[0], motion))
            last = float(time[-1] - time[0])
            late = time - time[0] > last - LAST * float(truth["period"])
            top = 1.5 * float(np.nanmax(np.abs(motion[late])))
            view = {"x": (last - LAST * float(truth["period"]), last), "y": (-top, top)}
        for method in collection.methods:
            seed, decay = panels.drawn(collection, scores, name, method, "decay")
            if answered(decay):
                predicted = at_probe(decay, "probe_displacement")
                time, predicted = panels.thinned(decay["time"].values, predicted, limit=POINTS)
                look = {"linewidth": 1.2}
                error = scores.value(name, method, seed, "decay", "nmte_percent")
                words = f"NMTE {error:.3g} %" if np.isfinite(error) else ""
                line = Series(method, time - time[0], predicted, seed=seed, name=words, look=look)
                series.append(line)
            if text := panels.ending(decay, "decay"):
                notes.append(f"{label(method)}: {text}.")
        words = "time since release [s]", "probe displacement [m]"
        made.append(Panel(name, *words, series, view=view, notes=notes))
    return made
