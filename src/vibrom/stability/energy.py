"""Mechanical energy of full-order states.

    E = 1/2 v'Mv + 1/2 q'Kq + sum_i int_0^1 f_i(s q)' q ds

which is exact for elastic forces of the third degree in q (St. Venant-Kirchhoff), whose work is of the third degree in s: two Gauss points. Forces without a
potential, such as a follower load, do work that depends on the path; this is then the work along the straight one.
"""

import numpy as np

from vibrom.term import Term

POINTS = ((0.5 - np.sqrt(3.0) / 6.0, 0.5), (0.5 + np.sqrt(3.0) / 6.0, 0.5))
WIDTH = 8  # states that the kernels take side by side


def energy(term: Term, displacement: np.ndarray, velocity: np.ndarray) -> np.ndarray:
    """E (m,) [J] of displacement [m] and velocity [m/s] (m, n)."""
    q, v = displacement.T, velocity.T
    total = 0.5 * np.sum(v * (term.mass @ v), axis=0)
    if term.stiffness is not None:
        total = total + 0.5 * np.sum(q * (term.stiffness @ q), axis=0)
    for share, weight in POINTS:
        total = total + weight * np.sum(q * forces(term, share * q), axis=0)
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
            q[:, :count] = displacement[:, first:first + count]
            kernel(q, np.zeros((n, WIDTH)), force.dofs, force.table, f)
            out[:, first:first + count] += f[:, :count]
    return out
