"""Figure 3.3: losses during training

Total loss (heavy) and its terms before they are weighted (thin, with markers) against the epoch,
on training data (solid) and, where it is recorded, on the test trajectory (dashed). One seed is
drawn, named in the title: the median one by decay NMTE. Methods that solve for their coefficients
directly have no history and are listed above. The thesis shows the case large.
"""

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from vibrom.report.drawing import layout, panels, style
from vibrom.report.plots import Panel, Series
from vibrom.thesis.labels import label

FAMILY = "models"
PLACE = 450
EACH = "scene"
DATA = ("run_times",)


def draw(collection, scores, scene) -> Figure:
    """A panel a method."""
    histories, without = [], []
    for method in collection.methods:
        seed, losses = panels.drawn(collection, scores, scene, method, "losses")
        if (
            losses is None
            or losses.sizes.get("epoch", 0) == 0
            or not np.isfinite(losses["train_total"].values).any()
        ):
            without.append(label(method))
        else:
            histories.append((method, seed, losses))
    figure, axes = layout.grid(max(1, len(histories)), height=1.1)
    terms = list(dict.fromkeys(term for _, _, losses in histories for term in names(losses)))
    handles: dict[str, Line2D] = {}
    for panel, (method, seed, losses) in zip(axes, histories):
        handles = curves(panel, losses, terms) | handles
        panel.set(title=panels.title(method, seed), yscale="log")
    for panel in axes:
        panel.set(xlabel="epoch [–]", ylabel="loss [–]")
    if not histories:
        layout.words(axes[0], "no method of this run has a loss history")
    note = (
        f"{scene}. No loss history, nothing is trained by epochs: {', '.join(without)}."
        if without
        else scene
    )
    layout.heading(figure, note)
    order = sorted(handles, key=lambda name: (not name.startswith("total"), name))
    layout.legend(figure, [handles[name] for name in order], order)
    return figure


def names(losses) -> list[str]:
    """Terms of the loss, without the total."""
    training = [str(name) for name in losses.data_vars if str(name).startswith("train_")]
    return [name.removeprefix("train_") for name in training if name != "train_total"]


def curves(panel, losses, terms: list[str]) -> dict[str, Line2D]:
    """Totals dark, terms thin; training solid, test dashed; colour and marker tell terms apart,
    alike in all panels.
    """
    epoch, handles = losses["epoch"].values, {}
    for role, dashes, words in (("train", "-", "training"), ("test", (0, (4, 1.5)), "test")):
        for index, term in enumerate(["total", *terms]):
            if f"{role}_{term}" not in losses:
                continue
            line = {"color": "black", "linewidth": 1.3, "linestyle": dashes}
            if term != "total":
                every = max(1, len(epoch) // 6)
                first = every * index // (len(terms) + 2)
                line = style.look(
                    index - 1,
                    linestyle=dashes,
                    linewidth=0.7,
                    markersize=3.2,
                    markevery=(first, every),
                )
            values = losses[f"{role}_{term}"].values
            line["label"] = f"{term.replace('_', ' ')}, {words}"
            handles[line["label"]] = panel.plot(
                epoch, np.where(values > 0, values, np.nan), **line
            )[0]
    return handles


def plot(collection, scores) -> list[Panel]:
    """Total loss of each training against the epoch, dashed on the test trajectory where that is
    recorded; the seeds that figures do not draw are faint.
    """
    made = []
    for scene in collection.scenes:
        series = []
        for method in collection.methods:
            chosen, _ = panels.drawn(collection, scores, scene, method, "losses")
            for seed in collection.seeds(scene, method):
                losses = collection.find(scene, method, "losses", seed)
                if losses is None or losses.sizes.get("epoch", 0) == 0:
                    continue
                for role, dashes in (("train", "-"), ("test", (0, (4, 1.5)))):
                    if f"{role}_total" in losses:
                        total = losses[f"{role}_total"].values
                        total = np.where(total > 0, total, np.nan)
                        look = {"linewidth": 1.2, "linestyle": dashes}
                        line = {"seed": seed, "name": role, "faint": seed != chosen, "look": look}
                        epoch = losses["epoch"].values.astype(float)
                        series.append(
                            Series(method, *panels.thinned(epoch, total, limit=250), **line)
                        )
        made.append(Panel(scene, "epoch [–]", "total loss [–]", series, log="y", switch="xy"))
    return made
