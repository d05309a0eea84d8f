"""What the figures of the methods' cost share: panels by question, a legend by method."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from vibrom.report.collection import Collection
from vibrom.report.cost import CONFIGURED, Pooled
from vibrom.report.drawing import layout, panels, style
from vibrom.thesis.labels import label

ERRORS = {
    "decay": "decay: NMTE [%]",
    "forced": "forced run: NMTE [%]",
    "frc": "response curve: error [%]",
}
NOT_STUDIED = "this scene was not studied"


def looks(collection: Collection, found: list[Pooled]) -> dict[str, dict]:
    """Of the methods of the run, then of any that only the study has."""
    return style.looks(dict.fromkeys([*collection.methods, *(one.method for one in found)]))


def known(found: list[Pooled], price: str, question: str, configured: bool) -> np.ndarray:
    """Price and error (2, settings) of the settings that have this answer; those as configured, or
    the others.
    """
    points = [
        (cost(one, price), one.error[question])
        for one in found
        if (one.varied == CONFIGURED) == configured and np.isfinite(one.error[question])
    ]
    return np.array(points).reshape(-1, 2).T


def cost(one: Pooled, price: str) -> float:
    """Seconds: `fit`, `offline`, or online for a question."""
    return getattr(one, price) if price in ("fit", "offline") else one.online[price]


def name_silent(panel, found: list[Pooled], question: str) -> None:
    """Names the methods of which no setting has this answer."""
    methods = dict.fromkeys(one.method for one in found)
    answered = {one.method for one in found if np.isfinite(one.error[question])}
    lost = [label(method) for method in methods if method not in answered]
    if lost:
        layout.words(panel, f"no setting has an answer: {', '.join(lost)}")


def finish(figure: Figure, handles: dict, methods: dict[str, dict]) -> None:
    """Plain numbers on the axes, and a legend in the order of the run, others last."""
    for panel in figure.axes:
        panels.decades(panel.xaxis)
        panels.decades(panel.yaxis)
    order = [label(method) for method in methods]
    names = sorted(handles, key=lambda name: order.index(name) if name in order else len(order))
    layout.legend(figure, [handles[name] for name in names], names)
