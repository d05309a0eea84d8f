"""How far the equations of motion trust a model

Error of the equations of motion along ellipses of the first reduced oscillator, over their largest
displacement; the dashed line is the tolerance up to which a model is trusted. One seed of each
method is drawn: the median one by decay NMTE.
"""

import numpy as np
from matplotlib.figure import Figure

from vibrom.artefacts.identity import FITTED_ONCE
from vibrom.report.collection import FULL_ORDER
from vibrom.report.columns import number
from vibrom.report.drawing import layout, style
from vibrom.thesis.labels import label

FAMILY = "trust"
PLACE = 830
EACH = "run"
DATA = ("trust",)


def draw(collection, scores, scene=None) -> Figure:
    """A panel a scene."""
    figure, axes = layout.grid(max(1, len(collection.scenes)), least=2.4, height=1.4)
    handles: dict = {}
    for panel, name in zip(axes, collection.scenes):
        panel.set(title=name, xlabel="largest displacement [m]", ylabel="error [%]", yscale="log")
        study = collection.find(name, FULL_ORDER, "trust")
        if study is None:
            layout.words(panel, "not part of this run")
            continue
        methods = list(dict.fromkeys(study["model"].values.tolist()))
        for method, look in style.looks(methods).items():
            seeds = [None if seed == FITTED_ONCE else int(seed) for seed in seeds_of(study, method)]
            seed = scores.median_seed(name, method, seeds)
            one = study.isel(fit=study["model"].values == method).isel(fit=seeds.index(seed))
            points = one["displacement"].values, one["error"].values
            if np.isfinite(points).any():
                handles[label(method)] = panel.plot(*points, **look | {"linewidth": 0.9})[0]
        panel.axhline(100 * study.attrs["tolerance"], color="0.3", linewidth=0.9, linestyle="--")
    if handles:
        layout.legend(figure, handles.values(), handles)
    return figure


def seen(collection, scores, scene=None) -> str:
    """How far the least trusted of each method's seeds is trusted."""
    parts = []
    for name in collection.scenes:
        study = collection.find(name, FULL_ORDER, "trust")
        for method in collection.methods if study is not None else ():
            reach = study["trusted_displacement"].values[study["model"].values == method]
            reach = np.nan_to_num(reach)
            if reach.size:
                parts.append(f"{name}, {label(method)}: trusted up to {number(reach.min(), 3)} m.")
    return " ".join(parts) or "Not part of this run."


def seeds_of(study, method: str) -> np.ndarray:
    """As they are stored."""
    return study["model_seed"].values[study["model"].values == method].astype(int)
