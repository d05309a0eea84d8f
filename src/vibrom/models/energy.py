"""Mechanical energy of full-order states, over that of the body at rest in q_0.

    E = 1/2 v'Mv + (q_0 + q/2)'Kq + sum_i int_0^1 f_i(q_0 + s q, 0)' q ds - p_0'q

The integral is the work of the forces along the straight path from rest; of forces without a
potential, such as a follower load, another path would give another work. It is taken by two of
Lobatto's rules on pieces of the path that are halved until the two agree to TOLERANCE: exact for
elastic forces of the third degree in q (St. Venant-Kirchhoff), and good to TOLERANCE for any other,
those that begin within the path (a stop) included.
"""

from typing import NamedTuple

import numpy as np

from vibrom.term import Term

TOLERANCE = 1e-9  # of the mean of |f'q| along the path
ROUNDING = 1e-14  # of the mean of sum |f_i q_i|: closer than that no rules come
HALVINGS = 30  # at most, to where a force begins
PIECES = 50  # of a path, at most
WIDTH, CHUNK = 8, 4096  # states that the kernels take side by side, and that are in memory at once


class Rule(NamedTuple):
    """Points in [0, 1], both ends among them, and two sets of weights."""

    points: np.ndarray
    fine: np.ndarray
    coarse: np.ndarray


def _rule(points: list[float], fine: list[float], coarse: list[float]) -> Rule:
    """From the positive points of [-1, 1], the middle first."""
    mirrored = [np.array([*part[:0:-1], *part]) for part in (fine, coarse)]
    inside = np.array([*(-point for point in points[:0:-1]), *points])
    return Rule(0.5 + 0.5 * inside, *(0.5 * weights for weights in mirrored))


# Lobatto's of five points and Simpson's: exact to degree 7 and 3 in s.
WHOLE = _rule([0.0, np.sqrt(3 / 7), 1.0], [32 / 45, 49 / 90, 1 / 10], [4 / 3, 0.0, 1 / 3])
# Lobatto's of four points and what Kronrod adds: 9 and 5 (Gander, Gautschi, BIT 40 (2000) 84).
PIECE = _rule(
    [0.0, np.sqrt(1 / 5), np.sqrt(2 / 3), 1.0],
    [672 / 1470, 625 / 1470, 432 / 1470, 77 / 1470],
    [0.0, 5 / 6, 0.0, 1 / 6],
)


def energy(
    term: Term, displacement: np.ndarray, velocity: np.ndarray, rest: np.ndarray
) -> np.ndarray:
    """E (m,) [J] of displacement q [m] from `rest` q_0 (n,) [m], the equilibrium under the dead
    load p_0, and velocity [m/s] (m, n).
    """
    q, v, rest = displacement.T, velocity.T, rest[:, None]
    total = 0.5 * np.sum(v * (term.mass @ v), axis=0)
    if term.stiffness is not None:
        total = total + np.sum(q * (term.stiffness @ (rest + 0.5 * q)), axis=0)
    if term.forces:
        total = total + work(term, q, rest)
    if term.dead_load is not None:
        total = total - term.dead_load @ q
    return total


def work(term: Term, q: np.ndarray, rest: np.ndarray) -> np.ndarray:
    """int_0^1 f(q_0 + s q)'q ds (m,) [J] of q (n, m) from rest (n, 1) [m]."""
    count = q.shape[1]
    total, near = np.zeros(count), np.zeros(count)
    state, begin, length = np.arange(count), np.zeros(count), 1.0  # of the pieces
    for halving in range(HALVINGS + 1):
        rule = PIECE if halving else WHOLE
        found = [power(term, rest, q[:, state], begin + length * at) for at in rule.points]
        net, gross = (np.stack(part) for part in zip(*found))  # (points, pieces)
        if halving == 0:
            near = 0.1 * TOLERANCE * rule.fine @ np.abs(net) + ROUNDING * rule.fine @ gross
        with np.errstate(invalid="ignore"):  # what has no value is not rough
            fine, coarse = (length * weights @ net for weights in (rule.fine, rule.coarse))
            rough = np.abs(fine - coarse) > near[state]
        if halving == HALVINGS or len(state) > PIECES * len(np.unique(state)):
            rough[:] = False
        np.add.at(total, state[~rough], fine[~rough])
        state, begin, length = state[rough], begin[rough], 0.5 * length
        if not len(state):
            break
        state, begin = np.tile(state, 2), np.concatenate([begin, begin + length])
    return total


def power(
    term: Term, rest: np.ndarray, path: np.ndarray, at: np.ndarray | float
) -> tuple[np.ndarray, np.ndarray]:
    """f'q and sum |f_i q_i| (k,) [J] at parts `at` of the paths q (n, k)."""
    at = np.broadcast_to(at, path.shape[1])
    net, gross = np.empty(path.shape[1]), np.empty(path.shape[1])
    for first in range(0, path.shape[1], CHUNK):
        some = slice(first, first + CHUNK)
        product = path[:, some] * forces(term, rest + at[some] * path[:, some])
        net[some], gross[some] = product.sum(axis=0), np.abs(product).sum(axis=0)
    return net, gross


def forces(term: Term, displacement: np.ndarray, velocity: np.ndarray | None = None) -> np.ndarray:
    """sum_i f_i(q, v) (n, m) [N] of displacements and velocities (n, m); None: at rest there."""
    n, states = displacement.shape
    out = np.zeros((n, states))
    q, v, f = np.zeros((3, n, WIDTH))
    kernels = [(force, force.kernels(WIDTH)[0]) for force in term.forces]
    for first in range(0, states, WIDTH):
        count = min(WIDTH, states - first)
        q[:, :count], f[:] = displacement[:, first : first + count], 0.0
        if velocity is not None:
            v[:, :count] = velocity[:, first : first + count]
        for force, kernel in kernels:
            kernel(q, v, force.dofs, force.table, f)
        out[:, first : first + count] = f[:, :count]
    return out
