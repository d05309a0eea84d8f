"""The smallest set of effects that a scene needs within a tolerance, found by trying sets.

    e(S) = max(NMTE of the decay, max |a_S - a| / max |a|),    S the effects that are left out,
    a the forced amplitudes of the probes

Effects that cannot be left out alone, or not without ending otherwise than the whole scene, stay.
Of up to FEW others all sets are tried, the largest first: errors of two effects may add up, or
cancel. Of more they are left out one after the other, the least error first, as long as the error
of all that are left out stays within the tolerance.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np
import xarray as xr

FEW = 4


@dataclass(frozen=True)
class Advice:
    """What may be left out."""

    left_out: tuple[str, ...]
    error: float  # percent
    tried: int  # sets whose error was computed, single effects included


def error(record: Mapping[str, Any], whole: Mapping[str, Any]) -> float:
    """e [percent]; infinite where it ends otherwise than the whole scene."""
    if record["outcome"] != whole["outcome"] or "decay_nmte" not in record:
        return np.inf
    own, true = (np.asarray(one["forced_amplitude"]) for one in (record, whole))
    largest = np.abs(true).max()
    forced = 100.0 * np.abs(own - true).max() / largest if largest else 0.0
    return float(np.nan_to_num(max(record["decay_nmte"], forced), nan=np.inf))


def advise(
    single: Mapping[str, Mapping[str, Any]],
    whole: Mapping[str, Any],
    tolerance: float,
    evaluate: Callable[[tuple[str, ...]], Mapping[str, Any]],
) -> Advice:
    """From the records of the scene without one effect each; `evaluate` makes that of a set."""
    known: dict[tuple[str, ...], float] = {
        (name,): error(record, whole) for name, record in single.items()
    }
    free = sorted((name for name in single if np.isfinite(known[name,])), key=lambda n: known[n,])

    def of(left_out: tuple[str, ...]) -> float:
        if left_out not in known:
            known[left_out] = error(evaluate(left_out), whole)
        return known[left_out]

    found: tuple[str, ...] = ()
    if len(free) <= FEW:
        for size in range(len(free), 0, -1):
            best = min(combinations(free, size), key=of)
            if of(best) <= 100.0 * tolerance:
                found = best
                break
    else:
        for name in free:
            if of((*found, name)) <= 100.0 * tolerance:
                found = (*found, name)
    return Advice(found, known.get(found, 0.0), len(known))


def variables(advice: Advice, ratio: float) -> dict[str, xr.Variable]:
    """As the study keeps it; `ratio` is the time of a step of the whole scene over that without
    what may be left out.
    """
    return {
        "advised": xr.Variable(
            (),
            " ".join(advice.left_out),
            {"units": "1", "long_name": "effects that may be left out together"},
        ),
        "advised_error": xr.Variable(
            (), advice.error, {"units": "percent", "long_name": "error without them"}
        ),
        "advised_ratio": xr.Variable(
            (), ratio, {"units": "1", "long_name": "wall time of a step with them over without"}
        ),
        "sets_tried": xr.Variable(
            (), advice.tried, {"units": "1", "long_name": "sets of effects that were tried"}
        ),
    }


def line(study: xr.Dataset, scene: str, listed: list[str]) -> str:
    """One sentence: what the scene needs, and what leaving out the rest saves."""
    within = f"within {100.0 * study.attrs['tolerance']:g} %"
    left_out = str(study["advised"].item()).split()
    if not left_out:
        return f"{within} {scene} needs all of its effects"
    needed = ", ".join(name for name in listed if name not in left_out).replace("_", " ")
    without = ", ".join(left_out).replace("_", " ")
    ratio = float(study["advised_ratio"])
    return (
        f"{within} {scene} needs {needed}: without {without} it is off by "
        f"{float(study['advised_error']):.2g} %, and a step is "
        f"{float(f'{ratio:.2g}'):g} times as fast"
    )
