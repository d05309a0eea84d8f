"""Branches of periodic motions: a response curve, stable or not, with what happens on it.

    x = H(x, Omega, a)   along Omega at one amplitude a of the forcing, or along a at one Omega

A curve begins with the motion that hangs together with rest (see `equations`), at both ends of its
range: there one motion is all there is, or else the others hang together with it. An isola hangs
together with none of them: guesses are needed, from the backbone (see `resonance`) or from sweeps.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from threadpoolctl import threadpool_limits

from vibrom.artefacts.outcome import Outcome
from vibrom.solvers.periodic import between, continuation, stability
from vibrom.solvers.periodic.continuation import Lost, Pace, Point, Problem, Value
from vibrom.solvers.periodic.equations import Along, from_rest
from vibrom.solvers.periodic.maps import Return, Swing
from vibrom.solvers.periodic.stability import Kind

FOLD = 1e-5  # slope of p, over its scale, along the branch: how well folds are located
CIRCLE = 1e-3  # |ln |mu||: how well other losses of stability are
PEAK = 3  # points that are added about a peak
AROUND = 4  # points from a start, which a branch that comes back passes again
SAME = 1e-3  # of the size of x: two motions at one frequency that differ by less are one


@dataclass(frozen=True)
class Orbit:
    """A periodic motion."""

    point: Point
    kind: Kind = Kind.REGULAR
    outcome: Outcome = Outcome.OK  # of a branch, at its end

    @property
    def p(self) -> float:
        """The parameter of the branch."""
        return self.point.p

    @property
    def multipliers(self) -> np.ndarray:
        """Of the map (m,)."""
        return self.point.value.details.multipliers


@dataclass(frozen=True)
class Span:
    """The part of a branch that is wanted."""

    lowest: float
    highest: float
    points: int  # at most
    minor: float  # folds nearer to each other than this, in p, are minor ones


Near = tuple[np.ndarray, float]  # x (m,) and p of a guess


@dataclass(frozen=True)
class Found:
    """An orbit, on which branch it lies and what it looks like."""

    branch: int
    orbit: Orbit
    swing: Swing
    multipliers: np.ndarray  # (m,) of the map


def branch(
    problem: Problem,
    start: Point,
    span: Span,
    pace: Pace,
    parts: int,
    known: Sequence[Orbit] = (),
) -> list[Orbit]:
    """The orbits from `start` on, along its tangent, to the end of the span, to a branch that is
    `known`, or back to the start; `parts` maps make a period.
    """
    orbits = [Orbit(start)]
    ending = Outcome.UNFINISHED
    walk = continuation.walk(problem, start, pace)
    while len(orbits) < span.points:
        try:
            ahead = next(walk)
        except Lost:
            ending = Outcome.LOST
            break
        before = orbits[-1].point
        if len(orbits) > AROUND and _meets(ahead.x, ahead.p, orbits[:AROUND]):
            length = np.linalg.norm((start.u - before.u) / before.scale(pace))
            ahead, ending = replace(start, arc=before.arc + float(length)), Outcome.OK
            orbits += [*_special(problem, before, ahead, pace, parts), Orbit(ahead)]
            break
        orbits += _special(problem, before, ahead, pace, parts)
        if not span.lowest < ahead.p < span.highest:
            edge = span.highest if ahead.p >= span.highest else span.lowest
            try:
                last = between.onto(problem, before, ahead, edge, pace)
            except Lost:
                orbits, ending = [o for o in orbits if o.point.arc <= before.arc], Outcome.LOST
                break
            orbits, ending = [o for o in orbits if o.point.arc < last.arc], Outcome.OK
            orbits.append(Orbit(last))
            break
        orbits.append(Orbit(ahead))
        met = _meets(ahead.x, ahead.p, known)
        if met or stability.wild(orbits[-1].multipliers, parts):
            ending = Outcome.OK if met else Outcome.LOST
            break
    orbits[-1] = replace(orbits[-1], kind=Kind.END, outcome=ending)
    return minor_folds(orbits, span.minor)


def through(
    problem: Problem, start: Point, span: Span, pace: Pace, parts: int, known: Sequence[Orbit] = ()
) -> list[Orbit]:
    """The whole branch on which `start` lies: an isola comes back to it, another one is followed
    to both sides.
    """
    forth = branch(problem, start, span, pace, parts, known)
    if forth[-1].point.x is start.x or len(forth) >= span.points:
        return forth
    turned = replace(start, tangent=-start.tangent)
    back = branch(problem, turned, replace(span, points=span.points - len(forth)), pace, parts)
    first = [
        replace(
            orbit,
            point=replace(orbit.point, arc=-orbit.point.arc, tangent=-orbit.point.tangent),
        )
        for orbit in reversed(back[1:])
    ]
    return minor_folds(first + forth, span.minor)


def _meets(x: np.ndarray, p: float, known: Sequence[Orbit]) -> bool:
    """Is this point between two that are known? Branches are apart by more than a chord sags."""
    for one, other in zip(known, known[1:]):
        low, high = one.point, other.point
        if one.kind == Kind.END or (p - low.p) * (high.p - p) < 0.0:
            continue
        chord = high.x - low.x
        share = (p - low.p) / ((high.p - low.p) or 1.0)
        apart = np.linalg.norm(x - low.x - share * chord)
        if apart <= 0.1 * np.linalg.norm(chord):
            return True
    return False


def _special(problem: Problem, left: Point, right: Point, pace: Pace, parts: int) -> list[Orbit]:
    """The orbits between two neighbours at which the branch folds or stability changes."""
    found: list[Orbit] = []
    if left.tangent[-1] * right.tangent[-1] < 0.0:
        points = between.root(
            problem,
            left,
            right,
            lambda point: point.tangent[-1],
            lambda point: abs(point.tangent[-1]) <= FOLD * pace.scale,
            pace,
        )
        found += _named(points, Kind.FOLD)
    before, after = (point.value.details.multipliers for point in (left, right))
    counts = stability.unstable(before), stability.unstable(after)
    if abs(counts[1] - counts[0]) > len(found[:1]):
        number = max(counts)
        points = between.root(
            problem,
            left,
            right,
            lambda point: stability.growth(point.value.details.multipliers, number),
            lambda point: abs(stability.growth(point.value.details.multipliers, number)) <= CIRCLE,
            pace,
        )
        if points:
            crossed = stability.leading_first(points[0].value.details.multipliers)[number - 1]
            found += _named(points, stability.crossing(complex(crossed), parts))
    return sorted(found, key=lambda orbit: orbit.point.arc)


def _named(points: list[Point], kind: Kind) -> list[Orbit]:
    """Orbits, the first of which is what was looked for."""
    return [Orbit(point, Kind.REGULAR if number else kind) for number, point in enumerate(points)]


def minor_folds(orbits: list[Orbit], width: float) -> list[Orbit]:
    """The same orbits; pairs of folds in a row that are closer than `width` are minor."""
    folds = [place for place, orbit in enumerate(orbits) if orbit.kind == Kind.FOLD]
    minor: set[int] = set()
    for one, other in zip(folds, folds[1:]):
        if one not in minor and abs(orbits[one].p - orbits[other].p) < width:
            minor |= {one, other}
    return [
        replace(orbit, kind=Kind.MINOR_FOLD) if place in minor else orbit
        for place, orbit in enumerate(orbits)
    ]


def response(curve: Along, span: Span, pace: Pace, near: Sequence[Near] = ()) -> list[Found]:
    """All branches that hang together with the motions from rest at the ends of the span, and those
    on which motions `near` some x and p lie. Where there is none, one row says so.
    """
    # Matrices of some hundred rows gain nothing from a second thread of BLAS, whose threads wait
    # for one another in a busy loop: eigenvalues take five times as long.
    with threadpool_limits(limits=1, user_api="blas"):
        found = _hanging_together(curve, span, pace)
        for x, p in near:
            found += _apart(curve, x, p, span, pace, found)
    return found or _nothing(curve, span.lowest)


def _hanging_together(curve: Along, span: Span, pace: Pace) -> list[Found]:
    flow = curve.flow
    found: list[Found] = []
    for p, toward in curve.ends(span.lowest, span.highest):
        try:
            start = continuation.at(curve, from_rest(flow, *curve.drive(p)), p, pace, toward)
        except Lost:
            continue
        room, known = span.points - len(found), [item.orbit for item in found]
        if room > 1 and not any(same(start, orbit.point) for orbit in known):
            orbits = branch(curve, start, replace(span, points=room), pace, flow.parts, known)
            number = len({item.branch for item in found})
            found += peaked(curve, _measured(curve, orbits, number), pace)
    return found


def _apart(
    curve: Along, x: np.ndarray, p: float, span: Span, pace: Pace, found: list[Found]
) -> list[Found]:
    """The branch on which the motion near x and p lies, unless it is among those found."""
    room, known = span.points - len(found), [item.orbit for item in found]
    inside = span.lowest < p < span.highest and np.isfinite(x).all()
    if room < 2 or not inside or _meets(x, p, known):
        return []
    try:
        start = continuation.at(curve, x, p, pace)
    except Lost:
        return []
    if _meets(start.x, start.p, known):
        return []
    orbits = through(curve, start, replace(span, points=room), pace, curve.flow.parts, known)
    return peaked(curve, _measured(curve, orbits, len({item.branch for item in found})), pace)


def _measured(curve: Along, orbits: list[Orbit], number: int) -> list[Found]:
    x, p = np.stack([orbit.point.x for orbit in orbits]), np.array([orbit.p for orbit in orbits])
    swings = curve.swings(x, p)
    return [Found(number, orbit, swing, orbit.multipliers) for orbit, swing in zip(orbits, swings)]


def _nothing(curve: Along, p: float) -> list[Found]:
    """A row without a motion."""
    size = curve.flow.size
    x = np.full(size, np.nan)
    value = Value(x, ok=False, details=Return(x, ok=False))
    point = Point(x, p, np.append(x, np.nan), value)
    swing = curve.flow.swings(np.zeros((1, size)), np.array([curve.drive(p)[0]]), np.zeros(1))[0]
    lost = replace(swing, displacement=np.full_like(swing.displacement, np.nan))
    return [Found(0, Orbit(point, Kind.END, Outcome.LOST), lost, x)]


def same(one: Point, other: Point) -> bool:
    """Are these one motion?"""
    size = np.linalg.norm(one.x)
    near = np.linalg.norm(one.x - other.x) <= SAME * size
    return bool(near and abs(one.p - other.p) <= 1e-9 * abs(one.p))


def peaked(curve: Along, found: list[Found], pace: Pace) -> list[Found]:
    """The same motions of one branch and up to PEAK more about the highest one, by parabolas."""
    found = list(found)
    for _ in range(PEAK):
        heights = [item.swing.displacement[0].max() for item in found]
        top = int(np.argmax(heights))
        if not 0 < top < len(found) - 1:
            break
        near = slice(top - 1, top + 2)
        arcs = np.array([item.orbit.point.arc for item in found[near]])
        bend, rise, _ = np.polyfit(arcs - arcs[1], heights[near], 2)
        shift = -0.5 * rise / bend if bend < 0.0 else 0.0
        side = top if shift > 0.0 else top - 1
        low, high = (item.orbit.point for item in found[side : side + 2])
        share = (arcs[1] + shift - low.arc) / (high.arc - low.arc)
        if not 0.05 < share < 0.95:
            break
        try:
            added = continuation.beyond(curve, low, share * (high.arc - low.arc), pace, high)
        except Lost:
            break
        found[side + 1 : side + 1] = _measured(curve, [Orbit(added)], found[top].branch)
    return found
