"""Error as training proceeds: each point is a model that was trained for so long; polynomial fits
beside them, by order.
"""

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from vibrom.report import cost
from vibrom.report.figures import panels, style
from vibrom.report.figures.cost_reduced import ASKED, ordered, silent, studied
from vibrom.thesis import published as thesis

EPOCHS = ("epochs", "start.epochs")


def draw(collection, scores, scene=None) -> Figure:
    table = cost.settings(cost.reduced(collection))
    known, methods = list(dict.fromkeys(table["case"])), studied(table, collection)
    figure = Figure(figsize=(8.6, 2.9 * max(1, len(known)) + 0.4))
    axes = figure.subplots(max(1, len(known)), 3, squeeze=False)
    handles: dict = {}
    for panels_of_row in axes:
        for panel, said in zip(panels_of_row, ASKED.values()):
            panel.set(
                xlabel="fit: mapping and dynamics [s]", ylabel=said, xscale="log", yscale="log"
            )
    if not known:
        panels.words(axes[0, 0], "no scene of this run was studied")
    for row, name in zip(axes, known):
        row[0].set_title(name)
        for panel, question in zip(row, ASKED):
            group = table[table["case"] == name]
            for index, method in enumerate(methods):
                handles |= lines(
                    panel,
                    group[group["method"] == method],
                    f"{question}_error_percent",
                    index,
                    thesis.label(method),
                )
            silent(panel, group, f"{question}_error_percent")
    for panel in axes.flat:
        panels.decades(panel.xaxis)
        panels.decades(panel.yaxis)
    figure.legend(*ordered(handles, methods), loc="outside lower center", ncols=5)
    return figure


def lines(panel, mine: pd.DataFrame, error: str, index: int, label: str) -> dict:
    """A line over the lengths of training, in epochs, or, of a method that does not train, over its
    orders; a large marker as configured. Failures are gaps.
    """
    usual = mine[(mine["varied"] == cost.CONFIGURED) & mine[error].notna()]
    trained = mine[mine["varied"].isin(EPOCHS)]
    chosen = trained if len(trained) else mine[mine["varied"].str.startswith("order")]
    large = style.look(index, linestyle="none", markersize=7, markeredgewidth=1.5)
    handles = {label: panel.plot(usual["fit_s"], usual[error], **large)[0]} if len(usual) else {}
    if chosen[error].notna().any():
        handles[label] = panel.plot(chosen["fit_s"], chosen[error], **style.look(index))[0]
    for x, y, said in zip(chosen["fit_s"], chosen[error], chosen["set_to"]):
        if np.isfinite(y):
            panel.annotate(
                said if len(trained) else f"p = {said}",
                (x, y),
                textcoords="offset points",
                xytext=(3, 3),
                fontsize=5.5,
                color="0.35",
            )
    return handles
