"""What the figures share: a grid with a panel for each method or scene, the words for a failure,
thinned lines.
"""

import math
import textwrap

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from vibrom.artefacts.outcome import Outcome
from vibrom.report.collection import Collection, outcome, scalar
from vibrom.report.scores import Scores
from vibrom.thesis.labels import label

WIDEST = 42  # letters of a note, which fill a panel three inches wide


def grid(
    count: int,
    *,
    columns: int = 3,
    size: tuple[float, float] = (3.1, 2.0),
    legend: float = 0.0,
    **subplots,
):
    """A figure and `count` axes; `legend` [inches] is added to the height for a legend below."""
    columns = max(1, min(columns, count))
    rows = max(1, math.ceil(count / columns))
    figure = Figure(figsize=(columns * size[0], rows * size[1] + legend))
    axes = figure.subplots(rows, columns, squeeze=False, **subplots).ravel()
    for spare in axes[count:]:
        spare.remove()
    return figure, list(axes[:count])


def words(axes, text: str, *, place: str = "centre") -> None:
    """A note in the panel; a long one takes several lines."""
    text = "\n".join(line for part in text.split("\n") for line in textwrap.wrap(part, WIDEST))
    at = {
        "centre": (0.5, 0.5, "center", "center"),
        "above": (0.98, 0.96, "right", "top"),
        "below": (0.02, 0.04, "left", "bottom"),
        "left": (0.03, 0.96, "left", "top"),
        "corner": (0.98, 0.05, "right", "bottom"),
    }[place]
    box = {
        "facecolor": "white",
        "edgecolor": "0.7",
        "linewidth": 0.5,
        "alpha": 0.9,
        "boxstyle": "round,pad=0.25",
    }
    align = {"ha": at[2], "va": at[3], "transform": axes.transAxes}
    axes.text(at[0], at[1], text, fontsize=7, style="italic", zorder=10, bbox=box, **align)


def ending(dataset: xr.Dataset | None, experiment: str) -> str:
    """How a prediction ended, as `diverged at 0.126 s`; empty where it ended well."""
    if dataset is None:
        return f"no {experiment} in this run"
    ended, failed_at = outcome(dataset), float(scalar(dataset, "failed_at"))
    if ended is Outcome.OK:
        return ""
    text = ended.sentence
    if np.isfinite(failed_at):
        text += f" at {failed_at:.3g} s"
    ratio = float(scalar(dataset, "range_ratio"))
    if ended is Outcome.LEFT_RANGE and np.isfinite(ratio):
        text += f" ({ratio:.3g} times)"
    reason = str(scalar(dataset, "reason", "")).strip()
    return f"{text}: {reason}" if reason else text


def drawn(
    collection: Collection, scores: Scores, scene: str, method: str, name: str
) -> tuple[int | None, xr.Dataset | None]:
    """The seed that is drawn (see `Scores.median_seed`) and its dataset of this name."""
    seeds = collection.seeds(scene, method)
    if not seeds:
        return None, None
    seed = scores.median_seed(scene, method, seeds)
    return seed, collection.find(scene, method, name, seed)


def title(method: str, seed: int | None, error: float = np.nan) -> str:
    """`SPLIT+, seed 1: 0.278 %`."""
    text = label(method) if seed is None else f"{label(method)}, seed {seed}"
    return f"{text}: {error:.3g} %" if np.isfinite(error) else text


def thinned(*arrays: np.ndarray, limit: int = 1500) -> list[np.ndarray]:
    """Every k-th sample (time is the last axis), at most `limit` of them: a panel shows no more."""
    step = max(1, math.ceil(arrays[0].shape[-1] / limit))
    return [array[..., ::step] for array in arrays]


def decades(axis) -> None:
    """Plain numbers at 1, 2 and 5 of each decade of a logarithmic axis, fewer where many decades
    meet.
    """
    low, high = axis.get_view_interval()
    steps = (1.0, 2.0, 5.0) if high < 30 * low else (1.0,)
    axis.set_major_locator(LogLocator(subs=steps, numticks=9))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.set_minor_formatter(NullFormatter())


def breathe(axes, values: np.ndarray, margin: float = 0.12) -> None:
    """Vertical limits from the reference, so that a blow-up does not flatten it."""
    low, high = np.nanmin(values), np.nanmax(values)
    pad = margin * max(high - low, 1e-300)
    axes.set_ylim(low - pad, high + pad)
