"""The periodic motions of a model along a curve, as an artefact keeps them: one a row, branch after
branch, with its stability and what is special about it.

Along the curve varies the frequency of the forcing, or its amplitude; the other one is a number.
"""

import time
from collections.abc import Callable

import numpy as np
import xarray as xr

from vibrom.artefacts.data import variable
from vibrom.artefacts.outcome import Outcome
from vibrom.models.curves import DRIVE, curve_of, difference, parameter
from vibrom.models.measures import periodic, range_variable, response_variables
from vibrom.models.rollout import MARGIN
from vibrom.solvers.periodic.continuation import Pace
from vibrom.solvers.periodic.equations import Along, prepare
from vibrom.solvers.periodic.harmonic_balance import HarmonicBalance
from vibrom.solvers.periodic.maps import Opinion
from vibrom.solvers.periodic.response import Found, Near, Span, response
from vibrom.solvers.periodic.stability import Kind, leading_first

Second = Callable[[np.ndarray, float, float], Opinion | None]  # of x, frequency and amplitude

HARMONICS = 8  # 0 to 7 are kept


def motions(
    curve: Along,
    span: Span,
    pace: Pace,
    grid: np.ndarray,
    probe: xr.Variable,
    near: Callable[[], list[Near]] = list,
    second: Second | None = None,
) -> xr.Dataset:
    """All that were found, those that guesses `near` them lead to among them; how many are stable
    at each of `grid`, and where two or more are; the `second` opinion of some of them.
    """
    prepare(curve.flow, curve.drive(span.lowest)[0])
    began = time.perf_counter()
    guesses = near()
    images = [(image, p) for x, p in guesses if (image := curve.image(x, p)) is not None]
    curve = curve.whole if images else curve
    found = response(curve, span, pace, guesses + images)
    opinions = _opinions(curve, found, second) if second else {}
    seconds = time.perf_counter() - began
    rows = opinions | _driven(curve, found) | _shown(found)
    rows |= _stability(found, curve.flow.parts) | _endings(found) | _balanced(curve, found)
    known = curve_of(xr.Dataset(rows))
    unit, varies = DRIVE[parameter(rows)]
    rows |= {
        "stable_motions": variable("grid", known.motions(grid), "1", "stable motions there"),
        "bistable_width": variable(
            (), known.bistable_width, unit, "width of what has two stable motions or more"
        ),
        "seconds": variable(
            (), seconds, "s", "wall time of the computation, loading and compilation excluded"
        ),
    }
    coords = {
        "probe": probe,
        "harmonic": variable("harmonic", np.arange(HARMONICS), "1", "multiple of the forcing"),
        "grid": variable("grid", grid, unit, f"{varies}, where stable motions are counted"),
    }
    return xr.Dataset(rows, coords=coords)


def errors(answer: xr.Dataset, truth: xr.Dataset, varies: str) -> dict[str, float]:
    """Where and how high a curve of motions folds and peaks, and how far its branches are off, by
    the names of scores; `varies` is what their names call the parameter.
    """
    curve = curve_of(answer)
    off = difference(curve, curve_of(truth))
    wrong = answer["stable_motions"].values != truth["stable_motions"].values
    return {
        "folds": float(len(curve.folds)),
        f"fold_{varies}_error_percent": off.fold_parameter,
        "fold_amplitude_error_percent": off.fold_amplitude,
        f"peak_{varies}_error_percent": off.peak_parameter,
        "peak_error_percent": off.peak_amplitude,
        "bistable_width_error_percent": off.bistable_width,
        "stable_amplitude_error_percent": off.stable_amplitude,
        "unstable_amplitude_error_percent": off.unstable_amplitude,
        "wrong_stable_motions": float(wrong.sum()),
    }


def _driven(curve: Along, found: list[Found]) -> dict[str, xr.Variable]:
    """Frequency and amplitude of the forcing: of each motion what varies, and one number."""
    drives = np.array([curve.drive(item.orbit.p) for item in found]).T
    return {
        name: variable("point" if given is None else (), values if given is None else given, *words)
        for (name, words), values, given in zip(
            DRIVE.items(), drives, (curve.frequency, curve.amplitude)
        )
    }


def _shown(found: list[Found]) -> dict[str, xr.Variable]:
    """What is seen of each motion at the probes."""
    swing = np.stack([item.swing.displacement for item in found], axis=1)  # (k, m, samples)
    shown, dims = periodic(swing), ("probe", "point")
    harmonic = np.abs(np.fft.rfft(swing)[..., :HARMONICS]) / swing.shape[-1]
    harmonic[..., 1:] *= 2.0
    return {
        "branch": variable("point", [item.branch for item in found], "1", "number of the branch"),
        **response_variables(dims, shown, largest="maximum"),
        "harmonic_amplitude": variable(
            (*dims, "harmonic"), harmonic, "m", "amplitude of each harmonic of the forcing"
        ),
    }


def _stability(found: list[Found], parts: int) -> dict[str, xr.Variable]:
    """Floquet's multipliers, of a whole period."""
    leading = [leading_first(item.multipliers)[0] for item in found]
    largest = np.array(leading, dtype=complex) ** parts
    names = {"real": largest.real, "imaginary": largest.imag}
    return {
        "stable": variable("point", np.int8(np.abs(largest) < 1.0), "1", "1: stable, 0: unstable"),
        "multiplier_largest": variable(
            "point", np.abs(largest), "1", "size of the largest Floquet multiplier"
        ),
        **{
            f"multiplier_{name}": variable(
                "point", part, "1", f"{name} part of the largest Floquet multiplier"
            )
            for name, part in names.items()
        },
    }


def _balanced(curve: Along, found: list[Found]) -> dict[str, xr.Variable]:
    """Of motions by harmonic balance: whether their harmonics are enough."""
    if not isinstance(curve.flow, HarmonicBalance):
        return {}
    missed = [item.orbit.point.value.details.open for item in found]
    return {
        "harmonics": variable((), curve.flow.harmonics, "1", "highest harmonic that is balanced"),
        "missed": variable(
            "point", missed, "1", "how far a period in time ends from its start, over the range"
        ),
    }


def _opinions(curve: Along, found: list[Found], second: Second) -> dict[str, xr.Variable]:
    """By harmonic balance, of the highest motion and those at which something happens."""
    height = [item.swing.displacement[0].max() for item in found]
    highest = int(np.nan_to_num(height, nan=-np.inf).argmax())
    frequency, missed = np.full((2, len(found)), np.nan)
    harmonics = np.zeros(len(found), int)
    maximum = np.full((len(found[0].swing.displacement), len(found)), np.nan)
    for place, item in enumerate(found):
        if item.orbit.kind == Kind.REGULAR and place != highest:
            continue
        opinion = second(item.orbit.point.x, *curve.drive(item.orbit.p))
        if opinion is not None:
            frequency[place], missed[place] = opinion.frequency, opinion.missed
            harmonics[place] = opinion.harmonics
            maximum[:, place] = opinion.displacement.max(axis=1)
    return {
        "balanced_harmonics": variable(
            "point", harmonics, "1", "highest harmonic that is balanced; 0: no second opinion"
        ),
        "balanced_frequency": variable(
            "point", frequency, "rad s-1", "where harmonic balance has a motion of this phase"
        ),
        "balanced_maximum": variable(
            ("probe", "point"), maximum, "m", "largest displacement of that motion"
        ),
        "balanced_missed": variable(
            "point", missed, "1", "what half as many harmonics more change, to the motion's size"
        ),
    }


def _endings(found: list[Found]) -> dict[str, xr.Variable]:
    """What is special about a motion."""
    kind = np.array([item.orbit.kind.value for item in found], dtype=object)
    ratio = np.array([item.swing.range_ratio for item in found])
    outcome = [
        Outcome.LEFT_RANGE if item.orbit.outcome == Outcome.OK and left else item.orbit.outcome
        for item, left in zip(found, ratio > MARGIN)
    ]
    words = np.array([word.value for word in outcome], dtype=object)
    ended = "how the branch ended there, or whether the motion leaves the training range"
    rows = {
        "kind": variable("point", kind, "1", f"one of {', '.join(Kind)}"),
        "outcome": variable("point", words, "1", ended),
        "failed_at": variable("point", np.full(len(found), np.nan), "s", "unused"),
    }
    if np.isfinite(ratio).any():
        rows |= range_variable("point", ratio)
    return rows
