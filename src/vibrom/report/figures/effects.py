"""What each effect of a scene is worth: decay and forced response without it, on those of the whole
scene, and the seconds of a step.
"""

import numpy as np
from matplotlib.figure import Figure

from vibrom.report.collection import FULL_ORDER, probe_name
from vibrom.report.effects import WHOLE
from vibrom.report.figures import panels, style


def draw(collection, scores, scene=None) -> Figure:
    worth = collection.find(scene, FULL_ORDER, "effects")
    if worth is not None:
        worth = worth.isel(
            probe=[str(name) for name in worth["probe"].values].index(probe_name(worth))
        )
    left_out = (
        [] if worth is None else [str(name) for name in worth["left_out"].values if name != WHOLE]
    )
    moving = [
        name
        for name in left_out
        if np.isfinite(worth["decay_displacement"].sel(left_out=name).values).any()
    ]
    figure = Figure(figsize=(9.4, max(2.6, 1.45 * len(moving) + 0.6)))
    grid = figure.add_gridspec(max(1, len(moving)), 3, width_ratios=(2.2, 1.2, 1.5))
    rows = [
        [figure.add_subplot(grid[row, column]) for column in (0, 1)]
        for row in range(max(1, len(moving)))
    ]
    bars = figure.add_subplot(grid[:, 2])
    bars.set(xlabel="wall time of a step [µs]", ylabel="left out [effect]")
    for row in rows:
        for panel, label in zip(
            row, ("time since release [s]", "time in the last forced period [s]")
        ):
            panel.set(xlabel=label, ylabel="probe [m]")
    if not moving:
        panels.words(rows[0][0], "no effect was left out" if left_out else "no effects in this run")
    for row, name in zip(rows, moving):
        compare(row, worth.sel(left_out=WHOLE), worth.sel(left_out=name), name)
    if left_out:
        cost(bars, worth, [WHOLE, *left_out])
    return figure


def compare(row, whole, less, name: str) -> None:
    """Decay and last forced period: the whole scene wide and pale, the scene without the effect
    thin and dashed.
    """
    for panel, quantity, instants in zip(row, ("decay", "forced"), ("time", "last_time")):
        for line, look in ((whole, style.TRUE), (less, style.PREDICTED)):
            panel.plot(less[instants].values, line[f"{quantity}_displacement"].values, **look)
    error, outcome, failed_at = (
        float(less["decay_nmte"]),
        str(less["outcome"].item()),
        float(less["failed_at"]),
    )
    row[0].set_title(
        f"without {name.replace('_', ' ')}"
        + (f": decay NMTE {error:.3g} %" if np.isfinite(error) else "")
    )
    if outcome != "ok":
        panels.words(
            row[int(np.isfinite(error))],
            outcome.replace("_", " ")
            + (f" at {failed_at:.3g} s" if np.isfinite(failed_at) else ""),
        )


def cost(panel, worth, names: list[str]) -> None:
    """Seconds of a step without each effect; those that cannot be left out say who needs them."""
    places = np.arange(len(names))
    seconds = 1e6 * worth["seconds_per_step"].sel(left_out=names).values
    panel.barh(
        places, np.nan_to_num(seconds), color=["0.72", *["#8a2a0b"] * (len(names) - 1)], height=0.6
    )
    panel.set_yticks(places, [name.replace("_", "\n") for name in names])
    panel.invert_yaxis()
    for place, name, value in zip(places, names, seconds):
        outcome = str(worth["outcome"].sel(left_out=name).item())
        text = f" {value:.3g}" if np.isfinite(value) else said(outcome)
        panel.text(
            value if np.isfinite(value) else 0.0,
            place,
            text,
            va="center",
            fontsize=6.5,
            style="normal" if np.isfinite(value) else "italic",
        )
    panel.set_xlim(0, 1.25 * np.nanmax([1e-9, *seconds]))


def said(outcome: str) -> str:
    """`needed_by a b` as words."""
    verdict, *others = outcome.split()
    return " ".join(
        [f" {verdict.replace('_', ' ')}", "\n ".join(name.replace("_", " ") for name in others)]
    )
