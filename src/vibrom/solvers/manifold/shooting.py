"""Periodic motions of the undamped body by shooting, followed in their action.

    M q'' + K q + f(q_0 + q) - f(q_0) = -M phi a sin(w t),    q(t + 2 pi/w) = q(t)

The steps damp numerically, the more the faster a harmonic is, so that harmonics which meet higher
frequencies of the body pass them; a small force a, along the mode phi and at phase resonance,
replaces what they take (`solvers.periodic.resonance`). Nothing limits the harmonics but the steps,
which lose (w h)^2/24 of a frequency. A derivative over a period is taken along the lowest modes of
small motions, as faster ones are damped away within it; its matrices are still as wide as there are
displacements and velocities: this is for bodies of some hundred displacements.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from threadpoolctl import threadpool_limits

from vibrom.solvers.full.modes import eigenmodes
from vibrom.solvers.full.newmark import Newmark
from vibrom.solvers.manifold.orbits import Orbits
from vibrom.solvers.periodic import continuation
from vibrom.solvers.periodic.continuation import Lost, Pace, Point
from vibrom.solvers.periodic.newmark_map import NewmarkMap
from vibrom.solvers.periodic.resonance import Resonance
from vibrom.term import Term

STEPS, DAMPING = 300, 0.05  # to a period; Newmark's alpha
TURN, SCALE = 0.5, 60.0  # rad; of the first force, which grows by far
TRIES, MOST = 4, 60  # motions from which it may begin; motions at most
MODES = 50  # along which derivatives are taken
WAIT, GROWTH = 6, 1e-4  # motions in which the root of the action has to grow by this part of it


def shoot(term: Term, rest: np.ndarray, mode: np.ndarray, begun: Orbits, last: float) -> Orbits:
    """The motions beyond those of `begun`, whose values are displacements from `rest` (n,), as far
    as the root of the action `last`, or as far as they can be followed while their action
    grows, which an internal resonance may turn back; none where none is found.
    """
    push = term.mass @ mode
    push *= -np.sign(push @ begun.values[-1, 0]) / np.sqrt(mode @ push)
    frequency = float(abs(begun.rate[-1]))
    bare = replace(term, damping=None, load=push)
    newmark, probes = Newmark(alpha=DAMPING), np.zeros(1, np.int64)
    flow = NewmarkMap(bare, newmark, STEPS, frequency, probes, np.array(rest))
    if term.size > MODES:
        flow = flow.only(eigenmodes(term, MODES).shape.T)
    found: list[tuple[float, complex, np.ndarray]] = []
    with threadpool_limits(limits=1, user_api="blas"):
        try:
            problem, point, pace = _begin(flow, begun)
            walk = continuation.walk(problem, point, pace)
            while len(found) < MOST and _leads_on([root for root, *_ in found], last):
                found.append(_measured(problem, term, point, begun))
                point = next(walk)
        except Lost:
            pass
    above = np.maximum.accumulate([np.sqrt(begun.action[-1]), *(root for root, _, _ in found)])
    kept = [item for item, before in zip(found, above) if item[0] > before]
    count = begun.values.shape[1]
    return Orbits(
        np.array([root for root, _, _ in kept]) ** 2,
        np.array([rate for _, rate, _ in kept], complex),
        np.array([values for _, _, values in kept]).reshape(-1, count, len(mode)),
    )


def _leads_on(roots: list[float], last: float) -> bool:
    """Are the roots of the action still below `last`, and growing?"""
    if len(roots) <= WAIT:
        return max(roots, default=0.0) < last
    return (1.0 + GROWTH) * max(roots[:-WAIT]) < max(roots) < last


def _begin(flow: NewmarkMap, begun: Orbits) -> tuple[Resonance, Point, Pace]:
    """The equations, a motion near one of those that are known, the largest first, and the pace."""
    places = np.unique(np.linspace(0, len(begun.action) - 1, TRIES + 1).astype(int))[:0:-1]
    for place in places:
        shape, frequency = begun.values[place, 0], float(abs(begun.rate[place]))
        x = flow.of_state(np.concatenate([shape, np.zeros_like(shape)]))
        along, size = abs(flow.load @ shape), float(np.linalg.norm(x))
        # The steps damp by alpha w h/2, h = 2 pi/(w STEPS).
        force = 2.0 * np.pi * DAMPING / STEPS * frequency**2 * along
        problem = Resonance(flow, frequency, size, along / size)
        pace = Pace(SCALE * force, turn=TURN)
        try:
            return problem, continuation.at(problem, np.append(x, 0.0), force, pace), pace
        except Lost:
            continue
    raise Lost("no motion was found near those that are known")


def _measured(
    problem: Resonance, term: Term, point: Point, begun: Orbits
) -> tuple[float, complex, np.ndarray]:
    """Root of the action, g and the displacements at equal angles (count, n)."""
    x, frequency = problem.drive(point.x)
    q, v = np.split(problem.flow.states(x, frequency, point.p), 2, axis=1)
    energy = float(np.mean(np.sum(v * (term.mass @ v.T).T, axis=1)))
    lost = 0.0
    if term.damping is not None:
        lost = float(np.mean(np.sum(v * (term.damping @ v.T).T, axis=1)))
    rate = -0.5 * lost / energy
    count, waves = begun.values.shape[1], np.fft.rfft(q, axis=0)
    values = np.fft.irfft(waves[: count // 2 + 1], count, axis=0) * (count / len(q))
    root = np.sqrt(energy / frequency / _unit(begun, term))
    return float(root), complex(rate, np.sqrt(frequency**2 - rate**2)), values


def _unit(begun: Orbits, term: Term) -> float:
    """2 w_0 of the action integral, from the last motion that is known."""
    values, frequency = begun.values[-1], float(abs(begun.rate[-1]))
    count = len(values)
    waves = 1j * np.arange(count // 2 + 1)[:, None] * np.fft.rfft(values, axis=0)
    slope = np.fft.irfft(waves, count, axis=0)
    return (
        frequency
        * float(np.mean(np.sum(slope * (term.mass @ slope.T).T, axis=1)))
        / float(begun.action[-1])
    )
