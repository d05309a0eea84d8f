"""What panels share: the words for a failure, which seed is drawn, thinned lines."""

import math

import numpy as np
import xarray as xr
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from vibrom.artefacts.outcome import Outcome
from vibrom.report.collection import Collection, outcome, scalar
from vibrom.report.scores import Scores
from vibrom.thesis.labels import label


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
    text = label(method) if seed is None else f"{label(method)}, seed\u00a0{seed}"
    return f"{text}: {error:.3g}\u00a0%" if np.isfinite(error) else text


def thinned(*arrays: np.ndarray, limit: int = 1500) -> list[np.ndarray]:
    """Every k-th sample (time is the last axis), at most `limit` of them: a panel shows no more."""
    step = max(1, math.ceil(arrays[0].shape[-1] / limit))
    return [array[..., ::step] for array in arrays]


def decades(axis) -> None:
    """Plain numbers at 1, 2 and 5 of each decade of a logarithmic axis, fewer where many decades
    meet.
    """
    low, high = axis.get_view_interval()
    steps = (1.0, 2.0, 5.0) if high < 30 * low else (1.0, 3.0) if high < 200 * low else (1.0,)
    axis.set_major_locator(LogLocator(subs=steps, numticks=9))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.set_minor_formatter(NullFormatter())


def breathe(axes, values: np.ndarray, margin: float = 0.12) -> None:
    """Vertical limits from the reference, so that a blow-up does not flatten it."""
    low, high = np.nanmin(values), np.nanmax(values)
    pad = margin * max(high - low, 1e-300)
    axes.set_ylim(low - pad, high + pad)
