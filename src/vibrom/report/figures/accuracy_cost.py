"""Accuracy against cost at a glance: decay NMTE against the seconds spent beforehand and those of a
prediction.
"""

import numpy as np
from matplotlib.figure import Figure

from vibrom.report.collection import FULL_ORDER
from vibrom.report.figures import panels, style
from vibrom.report.tables import outcome
from vibrom.thesis import published as thesis

OFFLINE = ("generate_training_data_s", "obtain_mapping_s", "obtain_dynamics_s")
FLOOR = 1e-5  # [s] a cost measured as zero is drawn here: the axis is logarithmic


def draw(collection, scores, scene=None) -> Figure:
    scenes = collection.scenes or [""]
    figure = Figure(figsize=(3.1 * len(scenes) + 0.4, 5.0))
    axes = figure.subplots(2, len(scenes), squeeze=False, sharex="row", sharey=True)
    handles = {}
    for column, name in enumerate(scenes):
        lost = []
        for row, panel in enumerate(axes[:, column]):
            panel.set(
                xscale="log",
                yscale="log",
                ylabel="decay NMTE [%]",
                xlabel=("offline: data, mapping, dynamics [s]", "online: one decay [s]")[row],
            )
            panel.tick_params(labelleft=True)
        axes[0, column].set_title(name)
        for index, method in enumerate(collection.methods):
            error = scores.spread(name, method, "decay", "nmte_percent")
            costs = cost(scores, name, method)
            if not np.isfinite(error.median):
                lost.append(
                    f"{thesis.label(method)}: {outcome(collection, scores, name, method, 'decay')}"
                )
                continue
            for panel, price in zip(axes[:, column], costs):
                if not np.isfinite(price):
                    continue
                marker = style.look(index, linestyle="none", markersize=7, markeredgewidth=1.4)
                handles[thesis.label(method)] = panel.plot(
                    max(price, FLOOR), error.median, **marker
                )[0]
                top = error.maximum if np.isfinite(error.maximum) else error.median
                seeds = {"color": marker["color"], "linewidth": 1.2, "zorder": 1}
                panel.plot([max(price, FLOOR)] * 2, [error.minimum, top], **seeds)
        full = seconds(scores, name, FULL_ORDER, "decay_s")
        if np.isfinite(full):
            online = axes[1, column]
            online.axvline(max(full, FLOOR), color="black", linewidth=1.2, linestyle=(0, (4, 2)))
            online.text(
                max(full, FLOOR),
                0.02,
                "full order ",
                rotation=90,
                ha="right",
                va="bottom",
                fontsize=7,
                transform=online.get_xaxis_transform(),
            )
        if lost:
            panels.words(axes[0, column], "no median:\n" + "\n".join(lost), place="above")
    for panel in axes.flat:
        panels.decades(panel.xaxis)
        panels.decades(panel.yaxis)
    figure.legend(list(handles.values()), list(handles), loc="outside lower center", ncols=4)
    return figure


def seconds(scores, scene: str, model: str, quantity: str) -> float:
    """One run time, median over seeds."""
    return scores.spread(scene, model, "run_times", quantity, worst=False).median


def cost(scores, scene: str, method: str) -> tuple[float, float]:
    """Offline and online seconds; parts that a method does not have count nothing."""
    parts = [seconds(scores, scene, method, quantity) for quantity in OFFLINE]
    offline = float(np.nansum(parts)) if np.isfinite(parts).any() else np.nan
    return offline, seconds(scores, scene, method, "decay_s")
