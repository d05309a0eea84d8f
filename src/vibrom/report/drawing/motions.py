"""Displacements of the probe against time, of each model and of the full order."""

import numpy as np
from matplotlib.figure import Figure

from vibrom.report.collection import answered, at_probe
from vibrom.report.drawing import panels, style
from vibrom.report.plots import Series
from vibrom.thesis.labels import label

POINTS = 1500  # of a line


def draw(collection, scores, scene, experiment: str) -> Figure:
    """A panel a method: the full order, and the model on it."""
    figure, axes = panels.grid(
        max(1, len(collection.methods)), columns=2, size=(4.4, 1.65), legend=0.45, sharex=True
    )
    figure.suptitle(scene, fontsize=8, x=0.01, ha="left", style="italic")
    for panel, method in zip(axes, collection.methods):
        seed, answer = panels.drawn(collection, scores, scene, method, experiment)
        panel.set(
            title=panels.title(
                method, seed, scores.value(scene, method, seed, experiment, "nmte_percent")
            ),
            xlabel="time [s]",
            ylabel="probe [m]",
        )
        panel.tick_params(labelbottom=True)
        if answered(answer):
            true, predicted = at_probe(answer, "probe_true"), at_probe(answer, "probe_displacement")
            time, true, predicted = panels.thinned(
                answer["time"].values, true, predicted, limit=POINTS
            )
            panel.plot(time, true, **style.TRUE | {"linewidth": 1.6}, label="full order")
            panel.plot(time, predicted, **style.PREDICTED, label="reduced model")
            panels.breathe(panel, true)
        if text := panels.ending(answer, experiment):
            panels.words(panel, text, place="above")
    handles = next((panel.get_legend_handles_labels() for panel in axes if panel.lines), ([], []))
    figure.legend(*handles, loc="outside lower center", ncols=2)
    return figure


def predicted(collection, scores, scene, experiment: str) -> tuple[list[Series], list[str]]:
    """A line for each method, of the median seed, and a note on each that did not go to the end."""
    series, notes = [], []
    for method in collection.methods:
        seed, answer = panels.drawn(collection, scores, scene, method, experiment)
        if answered(answer):
            motion = at_probe(answer, "probe_displacement")
            time, motion = panels.thinned(answer["time"].values, motion, limit=POINTS)
            error = scores.value(scene, method, seed, experiment, "nmte_percent")
            words = f"NMTE {error:.3g} %" if np.isfinite(error) else ""
            line = {"seed": seed, "name": words, "look": {"linewidth": 1.2}}
            series.append(Series(method, time - time[0], motion, **line))
        if text := panels.ending(answer, experiment):
            notes.append(f"{label(method)}: {text}.")
    return series, notes
