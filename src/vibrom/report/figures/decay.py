"""Figures 3.5 to 3.7: the predicted decay

Displacement of the probe (x = 0.525 m, bottom edge) in the test decay: full order (wide, pale)
and each reduced model (thin, dashed), with the NMTE over all displacements in the title. One seed
is drawn, named in the title: the median one by decay NMTE. The vertical axis is chosen by the
full order. A model that failed or left its training range says so in its panel.
"""

from matplotlib.figure import Figure

from vibrom.report.collection import answered, at_probe
from vibrom.report.drawing import panels, style

FAMILY = "models"
PLACE = 470
EACH = "scene"


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
