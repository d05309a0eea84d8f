"""Displacements of the probe against time, of each model and of the full order."""

import numpy as np
from matplotlib.figure import Figure

from vibrom.report.collection import answered, at_probe
from vibrom.report.drawing import layout, panels, style
from vibrom.report.plots import Series
from vibrom.thesis.labels import label

POINTS = 1500  # of a line


def draw(collection, scores, scene, experiment: str) -> Figure:
    """A panel a method: the full order, and the model on it."""
    figure, axes = layout.grid(max(1, len(collection.methods)), height=0.75, sharex=True)
    layout.heading(figure, scene)
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
            layout.words(panel, text)
    layout.legend(figure, *layout.of_panels(figure))
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
