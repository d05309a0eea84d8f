"""Figure 3.2: training and test decays

Displacement of the probe during the free decays of the full-order model: the methods learn from
the training decay and are tested on the other, which starts from a smaller state.
"""

import numpy as np
from matplotlib.figure import Figure

from vibrom.report.collection import FULL_ORDER, at_probe
from vibrom.report.columns import number
from vibrom.report.drawing import layout, panels

FAMILY = "models"
PLACE = 440
EACH = "run"
DATA = ("{scene}/full_order/train.nc", "{scene}/full_order/test.nc")

LINES = {
    "train": {"color": "0.55", "linewidth": 1.0, "label": "training"},
    "test": {"color": "#004c7a", "linewidth": 0.8, "linestyle": (0, (5, 1.2)), "label": "test"},
}


def draw(collection, scores, scene=None) -> Figure:
    """A panel a scene."""
    figure, axes = layout.grid(max(1, len(collection.scenes)), least=2.4)
    for panel, name in zip(axes, collection.scenes):
        panel.set(title=name, xlabel="time [s]", ylabel="probe displacement [m]")
        notes = []
        for role, line in LINES.items():
            run = collection.find(name, FULL_ORDER, role)
            if run is not None and np.isfinite(at_probe(run, "probe_displacement")).any():
                panel.plot(
                    *panels.thinned(
                        run["time"].values, at_probe(run, "probe_displacement"), limit=2400
                    ),
                    **line,
                )
            if text := panels.ending(run, f"{role} run"):
                notes.append(f"{role}: {text}" if run is not None else text)
        if notes:
            layout.words(panel, "\n".join(notes))
    layout.legend(figure, *layout.of_panels(figure))
    return figure


def seen(collection, scores, scene=None) -> str:
    """Where the decays begin, and how long they last."""
    parts = []
    for name in collection.scenes:
        for role in LINES:
            run = collection.find(name, FULL_ORDER, role)
            if text := panels.ending(run, f"{role} run"):
                parts.append(f"{name}, {role}: {text}.")
            else:
                first, last = at_probe(run, "probe_displacement")[[0, -1]]
                spent = float(run["time"].values[-1] - run["time"].values[0])
                parts.append(
                    f"{name}, {role}: from {number(first, 3)} m, after {number(spent, 3)} s at "
                    f"{number(last, 2)} m."
                )
    return " ".join(parts)
