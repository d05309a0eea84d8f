"""Mechanical energy of full-order states, over that of the body at rest in q_0.

    E = 1/2 v'Mv + (q_0 + q/2)'Kq + sum_i int_0^1 f_i(q_0 + s q)' q ds - p_0'q

which is exact for elastic forces of the third degree in q (St. Venant-Kirchhoff), whose work is of
the third degree in s: two Gauss points. Forces without a potential, such as a follower load, do
work that depends on the path; this is then the work along the straight one.
"""

import numpy as np

from vibrom.term import Term

POINTS = ((0.5 - np.sqrt(3.0) / 6.0, 0.5), (0.5 + np.sqrt(3.0) / 6.0, 0.5))
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
    for share, weight in POINTS:
        total = total + weight * np.sum(q * forces(term, rest + share * q), axis=0)
    if term.dead_load is not None:
        total = total - term.dead_load @ q
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
