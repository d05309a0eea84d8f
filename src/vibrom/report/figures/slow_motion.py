"""Where the slow motion of a recording begins

Above, the first channel of each recording as it is used: filtered, measured from rest, and from
where the slow motion begins. Below, what that follows from: of each period, the share of the
acceleration's power that is left by slow dynamics (polynomials of the slow coordinate and its
velocity) which are fitted to all later periods. The horizontal axis is time in the recording,
without what the filter leaves out. The dashed line is the limit; the vertical line is where the
share first is within it. A start that is set (`preparation.start`) replaces the rule's.
"""

import json

import numpy as np
from matplotlib.figure import Figure

from vibrom.report.collection import FULL_ORDER
from vibrom.report.drawing import layout, style

FAMILY = "models"
PLACE = 436
EACH = "scene"
DATA = ("{scene}/full_order/train.nc", "{scene}/full_order/test.nc")
RECORDED = True  # of recorded scenes only
ROLES = ("train", "test")


def draw(collection, scores, scene) -> Figure:
    """A column a role."""
    figure, axes = layout.grid(4)
    for column, role in enumerate(ROLES):
        record = collection.find(scene, FULL_ORDER, role)
        above, below = axes[column], axes[2 + column]
        above.set(title=f"{scene}, {role}", xlabel="time [s]", ylabel="displacement [m]")
        below.set(xlabel="time [s]", ylabel="share of fast motion [1]", yscale="log")
        if record is None or "fast_share" not in record:
            layout.words(above, "no recording in this run")
            continue
        above.plot(record["time"], record["probe_displacement"][0], color="0.4", linewidth=0.5)
        for number in range(record.sizes["recording"]):
            one, colour = record.isel(recording=number), style.COLOURS[number % 8]
            known = np.isfinite(one["fast_share"].values) & (one["fast_share"].values > 0.0)
            instant = one["window_instant"].values[known]
            below.plot(instant, one["fast_share"].values[known], color=colour, linewidth=0.9)
            below.axhline(float(one["fast_limit"]), color=colour, linewidth=0.7, linestyle="--")
            below.axvline(float(one["slow_begin"]), color=colour, linewidth=0.7)
        layout.words(below, "\n".join(notes(record)))
    return figure


def notes(record) -> list[str]:
    """What was done to each recording."""
    return [str(note) for note in json.loads(record.attrs.get("notes", "[]"))]


def seen(collection, scores, scene) -> str:
    """Where the rule finds the beginnings."""
    found = []
    for role in ROLES:
        record = collection.find(scene, FULL_ORDER, role)
        if record is not None and "slow_begin" in record:
            begins = ", ".join(f"{value:.4g} s" for value in record["slow_begin"].values)
            found.append(f"{scene}, {role}: slow motion begins at {begins}")
    return "; ".join(found) or "No recordings in this run."
