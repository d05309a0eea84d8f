"""Figure 3.11: a reduced model that blows up

The first forced run that a reduced model did not survive, looking at the hardest case first:
displacement of the probe by the full order (wide, pale) and by the reduced model (dashed), up to
the time at which it failed (dotted).
"""

import numpy as np
from matplotlib.figure import Figure

from vibrom.artefacts.outcome import Severity
from vibrom.report.collection import FULL_ORDER, at_probe, outcome, scalar
from vibrom.report.drawing import layout, panels, style

FAMILY = "models"
PLACE = 510
EACH = "run"
ASKED = "forced"  # where that is asked only
DATA = ("forced",)


def first_failure(collection):
    """Scene, method, seed and forced run of the first model that ran away (in the thesis: modal
    projection).
    """
    for scene in reversed(collection.scenes):
        for method in collection.methods:
            for seed in collection.seeds(scene, method):
                run = collection.find(scene, method, "forced", seed)
                failed = outcome(run).severity is Severity.FAILURE
                if failed and np.isfinite(float(scalar(run, "failed_at"))):
                    return scene, method, seed, run
    return None


def draw(collection, scores, scene=None) -> Figure:
    """One panel."""
    figure, (axes,) = layout.grid(1, height=1.5)
    axes.set(xlabel="time [s]", ylabel="probe displacement [m]")
    found = first_failure(collection)
    if found is None:
        layout.words(axes, "no reduced model of this run blew up under forcing")
        return figure
    name, method, seed, run = found
    truth = collection.find(name, FULL_ORDER, "forced")
    failed_at, period = float(scalar(run, "failed_at")), float(scalar(truth, "period", 0.0))
    end = failed_at + max(4 * period, 0.2 * failed_at)
    predicted = at_probe(run, "probe_displacement")
    largest = float(np.nanmax(np.abs(predicted))) if np.isfinite(predicted).any() else 1.0
    if truth is not None:
        early = truth["time"].values <= end
        true = at_probe(truth, "probe_displacement")[early]
        axes.plot(truth["time"].values[early], true, **style.TRUE, label="full order")
        largest = min(largest, 3 * float(np.nanmax(np.abs(true))))
    axes.plot(
        run["time"].values, predicted, **style.PREDICTED | {"linewidth": 1.1}, label="reduced model"
    )
    axes.axvline(failed_at, color="black", linewidth=0.8, linestyle=":")
    axes.set(xlim=(0, end), ylim=(-1.15 * largest, 1.15 * largest))
    axes.set_title(
        f"{panels.title(method, seed)} in case {name}, forcing {float(scalar(truth, 'forcing')):g}"
    )
    count = f", after {failed_at / period:.3g} periods" if period else ""
    layout.words(axes, panels.ending(run, "forced run") + count)
    layout.legend(figure, *layout.of_panels(figure))
    return figure


def seen(collection, scores, scene=None) -> str:
    """Whose run it is, and when it ended."""
    found = first_failure(collection)
    if found is None:
        return "No reduced model of this run blew up under forcing."
    name, method, seed, run = found
    return f"{panels.title(method, seed)} in case {name}: {panels.ending(run, 'forced run')}."
