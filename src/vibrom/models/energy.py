"""Mechanical energy of full-order states, over that of the body at rest in q_0.

    E = 1/2 v'Mv + (q_0 + q/2)'Kq + sum_i int_0^1 f_i(q_0 + s q, 0)' q ds - p_0'q

The integral is the work of the forces along the straight path from rest; of forces without a
potential, such as a follower load, another path would give another work. It is taken by Simpson's
rule over it and over its halves, and pieces of it are halved again where the two differ by more
than TOLERANCE: exact for elastic forces of the third degree in q (St. Venant-Kirchhoff), and good
to TOLERANCE for any other, those that begin within the path (a stop) included.
"""

import numpy as np

from vibrom.term import Term

TOLERANCE = 1e-9  # of the mean of |f'q| along the path
HALVINGS = 30  # at most, to where a force begins: the rest of the work is 4^-30 of it
WIDTH = 8  # states that the kernels take side by side


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

    def power(state: np.ndarray, at: np.ndarray) -> np.ndarray:
        """The product f'q [J] of these states (k,) at parts `at` (k,) of their paths."""
        path = q[:, state]
        return np.sum(path * forces(term, rest + at * path), axis=0)

    total, size = np.zeros(q.shape[1]), np.zeros(q.shape[1])
    # Pieces of paths: of which state, from where, how long, and f'q at both ends and the middle.
    state, begin, length = np.arange(q.shape[1]), np.zeros(q.shape[1]), 1.0
    at_rest = forces(term, rest)[:, 0] @ q
    ends = np.stack([at_rest, *(power(state, begin + part) for part in (0.5, 1.0))])
    for halving in range(HALVINGS + 1):
        inner = np.stack([power(state, begin + part * length) for part in (0.25, 0.75)])
        left, middle, right = ends
        coarse = length / 6.0 * (left + 4.0 * middle + right)
        fine = length / 12.0 * (left + 4.0 * inner.sum(axis=0) + 2.0 * middle + right)
        if halving == 0:
            size = np.abs([left, middle, right, *inner]).mean(axis=0)
        good = np.abs(fine - coarse) <= TOLERANCE * size[state]
        good |= halving == HALVINGS
        np.add.at(total, state[good], (fine + (fine - coarse) / 15.0)[good])
        if good.all():
            break
        state, begin, rough = state[~good], begin[~good], ~good
        ends = np.concatenate(
            [
                np.stack([left, inner[0], middle])[:, rough],
                np.stack([middle, inner[1], right])[:, rough],
            ],
            axis=1,
        )
        length *= 0.5
        state, begin = np.tile(state, 2), np.concatenate([begin, begin + length])
    return total


def forces(term: Term, displacement: np.ndarray) -> np.ndarray:
    """sum_i f_i(q, 0) (n, m) [N] at rest in `displacement` (n, m)."""
    n, states = displacement.shape
    out = np.zeros((n, states))
    for force in term.forces:
        kernel, _ = force.kernels(WIDTH)
        for first in range(0, states, WIDTH):
            count = min(WIDTH, states - first)
            q, f = np.zeros((n, WIDTH)), np.zeros((n, WIDTH))
            q[:, :count] = displacement[:, first : first + count]
            kernel(q, np.zeros((n, WIDTH)), force.dofs, force.table, f)
            out[:, first : first + count] += f[:, :count]
    return out
