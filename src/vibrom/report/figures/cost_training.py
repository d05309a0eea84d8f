"""Error as training proceeds

Each small marker is a model of its own, trained for a given number of epochs with the whole
learning-rate schedule, and placed at the seconds that it took; polynomial fits stand beside them,
by order p. Large markers are the models as configured. A gap is a model that failed.
"""

import numpy as np
from matplotlib.figure import Figure

from vibrom.report import cost
from vibrom.report.drawing import cost as drawing
from vibrom.report.drawing import layout
from vibrom.report.plots import Panel, Series
from vibrom.thesis.labels import label

FAMILY = "cost"
PLACE = 630
EACH = "scene"
DATA = ("cost_reduced",)
GLANCE = True
EPOCHS = ("epochs", "start.epochs")


def draw(collection, scores, scene) -> Figure:
    """A panel a question."""
    mine = [one for one in cost.pooled(collection) if one.scene == scene]
    looks = drawing.looks(collection, mine)
    figure, axes = layout.grid(len(drawing.ERRORS), least=layout.COLUMN, height=1.5)
    handles: dict = {}
    for panel, (question, words) in zip(axes, drawing.ERRORS.items()):
        panel.set(xlabel="fit: mapping and dynamics [s]", ylabel=words, xscale="log", yscale="log")
        panel.set_title(f"{scene}, {words.partition(':')[0]}")
        for method, group in cost.of_methods(mine).items():
            handles |= lines(panel, group, question, looks[method])
        drawing.name_silent(panel, mine, question)
    if not mine:
        layout.words(axes[0], drawing.NOT_STUDIED)
    drawing.finish(figure, handles, looks)
    return figure


def lines(panel, found: list[cost.Pooled], question: str, look: dict) -> dict:
    """A line over the lengths of training, in epochs, or, of a method that does not train, over its
    orders; a large marker as configured. Failures are gaps.
    """
    handles = {}
    usual = drawing.known(found, "fit", question, configured=True)
    if usual.size:
        large = look | {"linestyle": "none", "markersize": 5.5, "markeredgewidth": 1.2}
        handles[label(found[0].method)] = panel.plot(*usual, **large)[0]
    trained = [one for one in found if one.varied in EPOCHS]
    chosen = trained or [one for one in found if one.varied.startswith("order")]
    errors = [one.error[question] for one in chosen]
    if np.isfinite(errors).any():
        seconds = [one.fit for one in chosen]
        handles[label(found[0].method)] = panel.plot(seconds, errors, **look)[0]
    for one, error in zip(chosen, errors):
        if np.isfinite(error):
            words = one.set_to if trained else f"p = {one.set_to}"
            layout.name(panel, words, (one.fit, error), color="0.35")
    return handles


def plot(collection, scores) -> list[Panel]:
    """Small markers: a training of so many epochs, or a polynomial fit of this order, at the
    seconds that it took; large ones: as configured. A gap is a model that failed.
    """
    found, made = cost.pooled(collection), []
    for scene in dict.fromkeys(one.scene for one in found):
        mine = cost.of_methods([one for one in found if one.scene == scene])
        for question, words in drawing.ERRORS.items():
            lines = []
            for method, group in mine.items():
                trained = [one for one in group if one.varied in EPOCHS]
                chosen = trained or [one for one in group if one.varied.startswith("order")]
                usual = [one for one in group if one.varied == cost.CONFIGURED]
                for some, mode, size in ((chosen, "lines+markers", 3.2), (usual, "markers", 7.0)):
                    x, y = (
                        np.array(a)
                        for a in ([one.fit for one in some], [one.error[question] for one in some])
                    )
                    notes = [f"{one.varied} {one.set_to}".strip() for one in some]
                    if np.isfinite(y).any():
                        look = {"markersize": size, "linewidth": 1.1}
                        lines.append(Series(method, x, y, mode=mode, notes=notes, look=look))
            axis, title = "fit: mapping and dynamics [s]", f"{scene}, {words.partition(':')[0]}"
            made.append(Panel(title, axis, words, lines, log="xy", switch="xy"))
    return made
