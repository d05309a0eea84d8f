"""Accuracy of the methods against what it costs: every setting that was studied, offline and
online, with the Pareto front.
"""

import numpy as np
from matplotlib.figure import Figure

from vibrom.report import cost
from vibrom.report.collection import FULL_ORDER, scalar
from vibrom.report.figures import panels, style
from vibrom.studies.work_precision import front
from vibrom.thesis import published as thesis

ASKED = {
    "decay": "decay: NMTE [%]",
    "forced": "forced run: NMTE [%]",
    "frc": "response curve: error [%]",
}
TRUTH = {"decay": "test", "forced": "forced", "frc": "frc"}  # what the full-order model answers


def draw(collection, scores, scene=None) -> Figure:
    table = cost.settings(cost.reduced(collection))
    known, methods = list(dict.fromkeys(table["case"])), studied(table, collection)
    figure = Figure(figsize=(8.6, 5.2 * max(1, len(known))))
    axes = figure.subplots(2 * max(1, len(known)), 3, squeeze=False)
    handles: dict = {}
    for row in range(2 * max(1, len(known))):
        for panel, said in zip(axes[row], ASKED.values()):
            panel.set(
                ylabel=said,
                xlabel=("offline: data, mapping, dynamics [s]", "online: one answer [s]")[row % 2],
                xscale="log",
                yscale="log",
            )
    if not known:
        panels.words(axes[0, 0], "no scene of this run was studied")
    for index, name in enumerate(known):
        group = table[table["case"] == name]
        axes[2 * index, 0].set_title(name)
        for column, question in enumerate(ASKED):
            for panel, price in zip(
                axes[2 * index : 2 * index + 2, column], ("offline_s", f"{question}_s")
            ):
                handles = (
                    points(panel, group, price, f"{question}_error_percent", methods) | handles
                )
            silent(axes[2 * index, column], group, f"{question}_error_percent")
            full = float(scalar(collection.find(name, FULL_ORDER, TRUTH[question]), "seconds"))
            if np.isfinite(full):
                mark(axes[2 * index + 1, column], full)
    for panel in axes.flat:
        panels.decades(panel.xaxis)
        panels.decades(panel.yaxis)
    figure.legend(*ordered(handles, methods), loc="outside lower center", ncols=5)
    return figure


def studied(table, collection) -> list[str]:
    """The methods of the run, so that each looks as in its other figures, then any that only the
    study has.
    """
    return list(dict.fromkeys([*collection.methods, *table["method"]]))


def ordered(handles: dict, methods: list[str]) -> tuple[list, list[str]]:
    """Handles and labels in the order of the run, others last."""
    labels = [thesis.label(method) for method in methods]
    names = sorted(handles, key=lambda name: labels.index(name) if name in labels else len(labels))
    return [handles[name] for name in names], names


def points(panel, group, price: str, error: str, methods: list[str]) -> dict:
    """Small markers for settings that were varied, large ones as configured, and a grey line for
    the front of all.
    """
    handles = {}
    for method in dict.fromkeys(group["method"]):
        look = style.look(methods.index(method), linestyle="none")
        mine = group[(group["method"] == method) & group[error].notna()]
        usual = mine["varied"] == cost.CONFIGURED
        panel.plot(
            mine[price][~usual],
            mine[error][~usual],
            **look | {"markersize": 3.2, "markeredgewidth": 0.7},
        )
        if usual.any():
            handles[thesis.label(method)] = panel.plot(
                mine[price][usual],
                mine[error][usual],
                **look | {"markersize": 7, "markeredgewidth": 1.5},
            )[0]
    cost_of, error_of = group[price].to_numpy(float), group[error].to_numpy(float)
    best = front(cost_of, error_of)
    if len(best):
        handles["Pareto front"] = panel.step(
            cost_of[best], error_of[best], where="post", color="0.6", linewidth=1.4, zorder=0
        )[0]
    return handles


def silent(panel, group, error: str) -> None:
    """Names, above the panel, the methods of which no setting has this answer."""
    lost = [
        thesis.label(method)
        for method, mine in group.groupby("method", sort=False)
        if mine[error].isna().all()
    ]
    if lost:
        lines = [
            "no setting has an answer:",
            *(", ".join(lost[first : first + 3]) for first in range(0, len(lost), 3)),
        ]
        panel.set_title(
            "\n".join([panel.get_title(loc="left"), *lines]).strip(),
            fontsize=6.5,
            weight="normal",
            style="italic",
        )


def mark(panel, full: float) -> None:
    panel.axvline(full, color="black", linewidth=1.1, linestyle=(0, (4, 2)))
    panel.text(
        full,
        0.98,
        "full order ",
        rotation=90,
        ha="right",
        va="top",
        fontsize=6.5,
        transform=panel.get_xaxis_transform(),
    )
