"""Where models fail, by forcing and frequency

Colour: the part of the seeds whose run failed, forced from rest with the forcing (times the
scene's) and frequency (times the damped first frequency) of that place. A dot: most seeds left
their training range and went all the way. A row a method, a column a guard; first integrator.
Above each map stands how many of its runs failed. An empty one says what became of the model; a
dash: it has no such guard.
"""

import numpy as np
from matplotlib.figure import Figure

from vibrom.artefacts.outcome import Outcome
from vibrom.report import robustness
from vibrom.report.drawing import layout
from vibrom.studies.parts.grid import KINDS
from vibrom.thesis.labels import label

FAMILY = "robustness"
PLACE = 810
EACH = "scene"
DATA = ("robustness",)


def draw(collection, scores, scene) -> Figure:
    """A row a method, a column a guard."""
    groups = [
        group for group in robustness.groups(collection) if group.scene == scene and group.first
    ]
    guards = list(dict.fromkeys(group.guard for group in groups))
    figure, axes = layout.grid(
        max(1, len(groups)),
        least=layout.COLUMN / max(1, len(guards)),
        height=0.25,
        sharex=True,
        sharey=True,
    )
    image = None
    for panel, group in zip(axes, groups):
        panel.set(xlabel="frequency\u00a0[–]", ylabel="forcing [–]")
        panel.set_title(label(group.method) if group.guard == guards[0] else "")
        if panel in axes[: len(guards)]:
            layout.words(panel, group.guard.replace("_", " "))
        image = failures(panel, group) or image
    if image is None:
        layout.words(axes[0], "no robustness tests in this run")
    else:
        words = "part of the seeds that failed"
        figure.colorbar(image, ax=axes, location="bottom", shrink=0.4, aspect=40, label=words)
    return figure


def seen(collection, scores, scene) -> str:
    """How many runs of each method and guard failed."""
    parts = []
    for group in robustness.groups(collection):
        if group.scene == scene and group.first:
            runs = [answer.isel(run=answer["kind"].values == KINDS[0]) for answer in group.answers]
            ended = robustness.endings(run for run in runs if robustness.evaluated(run))
            lost = sum(not one.has_value for one in ended)
            parts.append(f"{label(group.method)}, {group.guard}: {lost} of {len(ended)} failed.")
    return " ".join(parts) or "No robustness tests in this run."


def failures(panel, group: robustness.Group):
    """The image, where there was a model to evaluate."""
    runs = [answer.isel(run=answer["kind"].values == KINDS[0]) for answer in group.answers]
    good = [run for run in runs if robustness.evaluated(run)]
    if not good:
        why = robustness.endings(runs)[0]
        layout.words(panel, "–" if why is Outcome.UNSUPPORTED else why.value.replace("_", " "))
        return None
    frequency, forcing = (np.unique(good[0][axis].values) for axis in ("frequency", "forcing"))
    # (seed, forcing, frequency): the runs are in the order of the grid
    ended = np.array([robustness.endings([run]) for run in good], dtype=object)
    ended = ended.reshape(len(good), len(forcing), len(frequency))
    lost = np.vectorize(lambda one: not one.has_value, otypes=[bool])(ended)
    outside = (ended == Outcome.LEFT_RANGE).mean(axis=0) > 0.5
    edges = (-0.5, len(frequency) - 0.5, -0.5, len(forcing) - 0.5)
    look = {"cmap": "Reds", "vmin": 0.0, "vmax": 1.0, "origin": "lower", "aspect": "auto"}
    image = panel.imshow(lost.mean(axis=0), extent=edges, **look)
    panel.plot(*np.nonzero(outside)[::-1], ".", color="0.45", markersize=2.2)
    panel.grid(False)
    ticks = np.linspace(0, len(frequency) - 1, min(4, len(frequency))).astype(int)
    panel.set_xticks(ticks, [f"{frequency[tick]:.3g}" for tick in ticks])
    ends = sorted({0, len(forcing) - 1})
    panel.set_yticks(ends, [f"{forcing[end]:g}" for end in ends])
    layout.words(panel, f"{lost.sum()}\u00a0of\u00a0{lost.size}")
    return image
