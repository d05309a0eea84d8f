"""Figure 3.9: the forced response

Displacement of the probe in a run forced from rest at the damped first frequency: on the left the
smallest and largest value of each period, on the right the last period itself. Full order wide
and pale, reduced model thin and dashed, NMTE of the last period in the title. One seed is drawn,
named in the title: the median one by decay NMTE. The thesis shows the case large.
"""

import numpy as np
from matplotlib.figure import Figure

from vibrom.report.collection import FULL_ORDER, answered, at_probe, scalar
from vibrom.report.drawing import layout, panels, style
from vibrom.report.plots import Panel, Series
from vibrom.thesis.labels import label

FAMILY = "models"
PLACE = 490
EACH = "scene"
ASKED = "forced"  # where that is asked only
DATA = ("forced",)
HEIGHT = 0.33  # [inches] of a panel


def draw(collection, scores, scene) -> Figure:
    """Two panels a method: the whole run and its last period."""
    methods = collection.methods
    rows = max(1, len(methods))
    figure = Figure(figsize=(layout.COLUMN, HEIGHT * rows))
    axes = figure.subplots(
        rows, 2, squeeze=False, sharex="col", sharey="row", width_ratios=(2.2, 1)
    )
    truth = collection.find(scene, FULL_ORDER, "forced")
    forcing = float(scalar(truth, "forcing"))
    heading = f"{scene}, forcing {forcing:g}" if np.isfinite(forcing) else scene
    layout.heading(figure, heading)
    for (whole, last), method in zip(axes, methods or [""]):
        seed, run = panels.drawn(collection, scores, scene, method, "forced")
        error = scores.value(scene, method, seed, "forced", "nmte_percent")
        ended = panels.ending(run, "forced run")
        title = panels.title(method, seed, error) + (f": {ended}" if ended else "")
        whole.set(title=title, xlabel="time [s]", ylabel="probe [m]")
        last.set(xlabel="last period [s]", ylabel="probe [m]")
        compare(whole, last, truth, run)
    layout.legend(figure, *layout.of_panels(figure))
    return figure


def envelope(
    time: np.ndarray, values: np.ndarray, period: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Middle [s], smallest and largest value of each period that has one."""
    bins = np.floor((time - time[0]) / period).astype(int)
    good = np.isfinite(values)
    numbers, sizes = np.unique(bins[good], return_counts=True)
    numbers = numbers[
        2 * sizes >= sizes.max()
    ]  # the last sample of a run begins a period that it does not fill
    lows = np.array([values[good & (bins == k)].min() for k in numbers])
    highs = np.array([values[good & (bins == k)].max() for k in numbers])
    return time[0] + (numbers + 0.5) * period, lows, highs


def compare(whole, last, truth, run) -> None:
    """Full order pale, the model thin and dashed, in both panels."""
    period = float(scalar(truth, "period", scalar(run, "period")))
    if not np.isfinite(period):
        return
    end = max(
        (float(data["time"].values[-1]) for data in (truth, run) if answered(data)), default=0.0
    )
    for data, line, name in (
        (truth, style.TRUE, "full order"),
        (run, style.PREDICTED, "reduced model"),
    ):
        values = at_probe(data, "probe_displacement") if answered(data) else None
        if values is None or not np.isfinite(values).any():
            continue
        time = data["time"].values
        middle, low, high = envelope(time, values, period)
        if name == "full order":
            whole.fill_between(middle, low, high, color="0.88", linewidth=0)
            panels.breathe(whole, values, margin=0.25)
        whole.plot(middle, low, **line)
        whole.plot(middle, high, **line, label=name)
        late = time >= end - period * (1 + 1e-9)
        last.plot(time[late], values[late], **line)
    last.set_xlim(end - period, end)
    last.locator_params(axis="x", nbins=2)


def plot(collection, scores) -> list[Panel]:
    """Displacement of the probe in the last period of the run forced from rest, which is what its
    error is of. Of each method the median seed.
    """
    made = []
    for name in collection.scenes:
        truth, series, notes = collection.find(name, FULL_ORDER, "forced"), [], []
        if answered(truth):
            series.append(Series(FULL_ORDER, *last_period(truth, truth)))
        for method in collection.methods:
            seed, run = panels.drawn(collection, scores, name, method, "forced")
            if answered(run):
                line = {"seed": seed, "look": {"linewidth": 1.2}}
                series.append(Series(method, *last_period(run, truth), **line))
            if text := panels.ending(run, "forced run"):
                notes.append(f"{label(method)}: {text}.")
        words = "time in the last period [s]", "probe displacement [m]"
        made.append(Panel(name, *words, series, notes=notes))
    return made


def last_period(run, truth) -> tuple[np.ndarray, np.ndarray]:
    """Time from its beginning [s], and displacement of the probe [m]."""
    period = float(scalar(truth, "period", scalar(run, "period")))
    time, end = run["time"].values, float((run if truth is None else truth)["time"].values[-1])
    late = time >= end - period * (1 + 1e-9)
    return time[late] - (end - period), at_probe(run, "probe_displacement")[late]
