"""Ablation: motion without each effect

The decay and the last period of the forced run at the probe, of the whole scene (wide, pale) and
without one effect (thin, dashed), with the NMTE between both decays in the title; below
the median wall time of a step without each effect, that of the whole scene on top. Effects that
cannot be left out alone are named there with those that need them.
"""

import numpy as np
from matplotlib.figure import Figure

from vibrom.artefacts.outcome import Outcome
from vibrom.report.collection import FULL_ORDER, outcome, probe_name, scalar
from vibrom.report.columns import number
from vibrom.report.drawing import layout, panels, style

FAMILY = "ablation"
PLACE = 710
EACH = "scene"
DATA = ("ablation",)
WHOLE = "nothing"  # what is left out of the whole scene
AXES = ("time since release [s]", "time in the last forced period [s]")


def draw(collection, scores, scene=None) -> Figure:
    """A row an effect; bars beside them."""
    study = collection.find(scene, FULL_ORDER, "ablation")
    left_out, moving = [], []
    if study is not None:
        study = study.sel(probe=probe_name(study))
        left_out = [str(name) for name in study["left_out"].values if name != WHOLE]
        moving = [name for name in left_out if moves(study.sel(left_out=name))]
    rows = max(1, len(moving))
    heights = [0.7] * rows + [0.3 * len(left_out) + 0.4]
    figure = Figure(figsize=(layout.COLUMN, sum(heights)))
    grid = figure.add_gridspec(rows + 1, 2, width_ratios=(2, 1), height_ratios=heights)
    axes = [[figure.add_subplot(grid[row, column]) for column in (0, 1)] for row in range(rows)]
    bars = figure.add_subplot(grid[rows, :])
    bars.set(xlabel="wall time of a step [µs]", ylabel="left out [effect]")
    for row in axes:
        for panel, words in zip(row, AXES):
            panel.set(xlabel=words, ylabel="probe [m]")
    if not moving:
        text = "no effect was left out" if left_out else "no ablation in this run"
        layout.words(axes[0][0], text)
    for row, name in zip(axes, moving):
        compare(row, study.sel(left_out=WHOLE), study.sel(left_out=name), name)
    if left_out:
        cost(bars, study.sel(left_out=[WHOLE, *left_out]))
    return figure


def seen(collection, scores, scene=None) -> str:
    """What each effect is worth."""
    study = collection.find(scene, FULL_ORDER, "ablation")
    parts = []
    for name in study["left_out"].values if study is not None else ():
        less = study.sel(left_out=name)
        if name != WHOLE:
            error = float(less["decay_nmte"])
            worth = f"decay NMTE {number(error, 3)} %" if np.isfinite(error) else why(less)
            words = " ".join(f"without {name}: {worth}.".replace("_", " ").split())
            parts.append(f"{words[0].upper()}{words[1:]}")
    return " ".join(parts) or "No ablation in this run."


def moves(less) -> bool:
    """Is there a decay to draw?"""
    return bool(np.isfinite(less["decay_displacement"].values).any())


def compare(row, whole, less, name: str) -> None:
    """Decay and last forced period: the whole scene wide and pale, the scene without the effect
    thin and dashed.
    """
    for panel, experiment, instants in zip(row, ("decay", "forced"), ("time", "last_time")):
        for line, look in ((whole, style.TRUE), (less, style.PREDICTED)):
            panel.plot(less[instants].values, line[f"{experiment}_displacement"].values, **look)
    error = float(less["decay_nmte"])
    nmte = f": decay NMTE {error:.3g} %" if np.isfinite(error) else ""
    row[0].set_title(f"without {name.replace('_', ' ')}{nmte}")
    if text := panels.ending(less, "ablation"):
        layout.words(row[int(np.isfinite(error))], text)


def cost(panel, study) -> None:
    """Seconds of a step without each effect; those that cannot be left out say why."""
    names = [str(name) for name in study["left_out"].values]
    places, seconds = np.arange(len(names)), 1e6 * study["seconds_per_step"].values
    colours = ["0.72", *["#8a2a0b"] * (len(names) - 1)]
    panel.barh(places, np.nan_to_num(seconds), color=colours, height=0.6)
    panel.set_yticks(places, [name.replace("_", "\n") for name in names])
    panel.invert_yaxis()
    look = {"va": "center", "fontsize": layout.SMALL}
    for place, value in zip(places, seconds):
        if np.isfinite(value):
            panel.text(value, place, f" {value:.3g}", **look)
        else:
            panel.text(0.0, place, f" {why(study.isel(left_out=place))}", style="italic", **look)
    panel.set_xlim(0, 1.25 * np.nanmax([1e-9, *seconds]))


def why(less) -> str:
    """An effect cannot be left out alone, or what is left cannot be evaluated."""
    if outcome(less) is Outcome.NEEDED:
        others = str(scalar(less, "needed_by", "another")).split()
        words = f"needed by {', '.join(others)}".replace("_", " ")
        return layout.fold(words, 2.0, layout.SMALL).replace("\n", "\n ")
    return outcome(less).sentence
