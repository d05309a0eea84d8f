"""Numbers of response curves with branches, each defined once: how many motions are stable, folds,
the peak, and how far one curve is from another.

A curve is a list of periodic motions, branch after branch, in the order in which they hang
together; along it varies the frequency of the forcing, or its amplitude. Two curves are compared
along their arclength, landmark by landmark (ends and main folds): at one frequency a curve with
folds has several amplitudes, and one that is a little off has none where the other one jumps.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
import xarray as xr

from vibrom.solvers.periodic.stability import Kind

NAMES = ("branch", "parameter", "amplitude", "stable", "kind")
FLAT = 1e-3  # of the largest amplitude: motions that differ by less are all at the top
SAMPLES = 200  # of each part of a branch between two landmarks
DRIVE = {  # of the forcing: unit and meaning
    "angular_frequency": ("rad s-1", "angular frequency of the forcing"),
    "forcing": ("1", "amplitude of the forcing, times the scene's load"),
}


@dataclass(frozen=True)
class Curve:
    """Periodic motions, one entry each."""

    branch: np.ndarray  # (m,) number of the branch
    parameter: np.ndarray  # (m,) what varies: rad/s of a frequency, 1 of a forcing
    amplitude: np.ndarray  # (m,) m
    stable: np.ndarray  # (m,) bool
    kind: np.ndarray  # (m,) words of Kind

    def part(self, chosen: np.ndarray | slice) -> Curve:
        """Some of the motions."""
        return Curve(*(getattr(self, name)[chosen] for name in NAMES))

    @property
    def links(self) -> np.ndarray:
        """(k, 2) neighbours on one branch."""
        (first,) = np.nonzero(self.branch[1:] == self.branch[:-1])
        return np.stack([first, first + 1], axis=1)

    @property
    def stable_links(self) -> np.ndarray:
        """(k, 2) neighbours between which motions are stable. Where stability changes it counts
        for neither side.
        """
        changes = ~np.isin(self.kind, [Kind.REGULAR, Kind.END])
        links = self.links
        calm = (self.stable | changes)[links].all(axis=1) & ~changes[links].all(axis=1)
        return links[calm]

    def motions(self, parameter: np.ndarray) -> np.ndarray:
        """(g,) how many stable motions there are at each of (g,) values of the parameter."""
        low, high = np.sort(self.parameter[self.stable_links], axis=1).T
        inside = np.clip(parameter, *(self.parameter.min(), np.nextafter(self.parameter.max(), 0)))
        return ((low <= inside[:, None]) & (inside[:, None] < high)).sum(axis=1)

    @property
    def bistable_width(self) -> float:
        """How much of the parameter has two stable motions or more."""
        edges = np.unique(self.parameter[self.stable_links])
        if len(edges) < 2:
            return 0.0
        several = self.motions(0.5 * (edges[1:] + edges[:-1])) > 1
        return float(np.diff(edges)[several].sum())

    @property
    def folds(self) -> np.ndarray:
        """(f,) places of the main folds."""
        return np.nonzero(self.kind == Kind.FOLD)[0]

    @property
    def peak(self) -> int:
        """Place of the largest amplitude."""
        return int(np.argmax(self.amplitude))

    @property
    def top(self) -> tuple[float, float]:
        """How much of the parameter the top takes up, at least and at most: motions about the peak
        whose amplitude is the largest but for FLAT, and these with their neighbours.
        """
        peak, at = self.peak, self.parameter
        inside, about = [at[peak]], [at[peak]]
        for step in (-1, 1):
            place = peak + step
            while 0 <= place < len(at) and self.branch[place] == self.branch[peak]:
                about.append(at[place])
                if self.amplitude[place] < (1.0 - FLAT) * self.amplitude[peak]:
                    break
                inside.append(at[place])
                place += step
        return float(np.ptp(inside)), float(np.ptp(about))


def parameter(answer: xr.Dataset | dict[str, xr.Variable]) -> str:
    """What varies along the curve."""
    return next(name for name in DRIVE if answer[name].ndim)


def curve_of(answer: xr.Dataset, amplitude: np.ndarray | None = None) -> Curve:
    """The curve of these amplitudes (m,) [m]; if none are given, of the first probe."""
    names = ("branch", parameter(answer), "stable", "kind")
    branch, varies, stable, kind = (answer[name].values for name in names)
    shown = answer["maximum"].values[0] if amplitude is None else amplitude
    return Curve(branch, varies, shown, stable.astype(bool), kind.astype(str))


@dataclass(frozen=True)
class Difference:
    """One curve against the true one, in percent; infinite where it lacks what the true one has."""

    fold_parameter: float  # largest of the main folds
    fold_amplitude: float  # largest of the main folds
    # NaN of an amplitude that saturates about the true place: on a flat top there is no such place
    peak_parameter: float
    peak_amplitude: float
    bistable_width: float
    stable_amplitude: float  # largest along the stable parts of matched branches
    unstable_amplitude: float  # largest along the unstable ones; zero where there are none


def difference(curve: Curve, truth: Curve) -> Difference:
    """How far `curve` is from `truth`; peak and width with their signs. NaN where there is nothing
    to compare with.
    """
    for item, value in ((truth, float("nan")), (curve, float("inf"))):
        if not np.isfinite(item.amplitude).all():
            return Difference(*(value for _ in fields(Difference)))
    folds, true_folds = curve.folds, truth.folds
    matched = len(folds) == len(true_folds) and _complete(curve) == _complete(truth)

    def off(name: str, one: np.ndarray | int, other: np.ndarray | int) -> np.ndarray:
        return 100.0 * (getattr(curve, name)[one] / getattr(truth, name)[other] - 1.0)

    def worst(name: str) -> float:
        if len(folds) != len(true_folds):
            return float("inf")
        return float(np.abs(off(name, folds, true_folds)).max(initial=0.0))

    inside, about = curve.top
    apart = abs(curve.parameter[curve.peak] - truth.parameter[truth.peak])
    saturated = inside > truth.top[1] and apart <= about
    peak = float("nan") if saturated else float(off("parameter", curve.peak, truth.peak))
    stable, unstable = _along(curve, truth) if matched else (float("inf"), float("inf"))
    return Difference(
        worst("parameter"),
        worst("amplitude"),
        peak,
        float(off("amplitude", curve.peak, truth.peak)),
        _share(curve.bistable_width, truth.bistable_width),
        stable,
        unstable,
    )


def _complete(curve: Curve) -> list[int]:
    """Landmarks of each branch."""
    marks = np.isin(curve.kind, [Kind.FOLD, Kind.END])
    return np.bincount(curve.branch, weights=marks).astype(int).tolist()


def _share(one: float, other: float) -> float:
    if other == 0.0:
        return 0.0 if one == 0.0 else float("inf")
    return 100.0 * (one / other - 1.0)


def _parts(curve: Curve) -> list[Curve]:
    """The branches, cut at their main folds."""
    parts = []
    for number in np.unique(curve.branch):
        branch = curve.part(curve.branch == number)
        cuts = [0, *branch.folds, len(branch.parameter) - 1]
        parts += [branch.part(slice(one, other + 1)) for one, other in zip(cuts, cuts[1:])]
    return parts


def _along(curve: Curve, truth: Curve) -> tuple[float, float]:
    """Largest errors of the amplitude along stable and along unstable parts of the true curve."""
    worst = {True: 0.0, False: 0.0}
    size = np.array([np.ptp(truth.parameter) or 1.0, truth.amplitude.max()])
    share = np.linspace(0.0, 1.0, SAMPLES)
    for part, true in zip(_parts(curve), _parts(truth)):
        model, reference = (_sampled(item, size, share) for item in (part, true))
        error = 100.0 * np.abs(model / reference - 1.0)
        links = true.stable_links
        calm = np.zeros(len(true.parameter) - 1, bool)
        calm[links[:, 0]] = True
        at = np.clip(
            np.searchsorted(_lengths(true, size), share, side="right") - 1, 0, len(calm) - 1
        )
        for stable in worst:
            worst[stable] = max(worst[stable], float(error[calm[at] == stable].max(initial=0.0)))
    return worst[True], worst[False]


def _lengths(curve: Curve, size: np.ndarray) -> np.ndarray:
    """(m,) arclength up to each point, in units of the whole."""
    path = np.stack([curve.parameter, curve.amplitude], axis=1) / size
    length = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1)))
    return length / length[-1]


def _sampled(curve: Curve, size: np.ndarray, share: np.ndarray) -> np.ndarray:
    """The amplitude at these parts of the arclength."""
    from scipy.interpolate import Akima1DInterpolator  # slow to import, and few compare

    length = _lengths(curve, size)
    kept = np.append(True, np.diff(length) > 0.0)
    if kept.sum() < 3:
        return np.interp(share, length, curve.amplitude)
    return Akima1DInterpolator(length[kept], curve.amplitude[kept])(share)
