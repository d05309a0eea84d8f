"""The pencil bordered by masters, against dense systems of all its unknowns."""

import numpy as np
from few_dofs import TWO_DAMPING, TWO_MASS, TWO_STIFFNESS, two
from scipy.sparse import csr_matrix

from vibrom.solvers.full.modes import eigenmodes
from vibrom.solvers.manifold.bordered import Bordered
from vibrom.solvers.manifold.masters import masters
from vibrom.solvers.manifold.pencil import Pencil


def test_systems_at_eigenvalues_and_at_conjugates_are_those_of_dense_matrices():
    m, c, k = TWO_MASS, TWO_DAMPING + [[0.0, 0.02], [-0.01, 0.0]], TWO_STIFFNESS
    pencil = Pencil(*(csr_matrix(part) for part in (m, c, k)))
    frequency, shape = eigenmodes(two(), 1)
    found = masters(pencil, frequency, shape)
    value, random = found.eigenvalues[0], np.random.default_rng(0)
    s = np.array([value, 0.3 - 2j, 0.3 + 2j, value.conj(), -0.7, 0.3 - 2j])
    f, g = (random.normal(size=(6, 2, 2)) @ [1.0, 1j] for _ in range(2))
    w, r = Bordered(pencil, found).solve(s, f, g)
    for at, *parts in zip(s, f, g, w, r):
        edges = [(at + each) * m + c for each in found.eigenvalues]
        columns = np.stack([e @ phi for e, phi in zip(edges, found.shapes)], axis=1)
        rows = np.stack([psi @ e for e, psi in zip(edges, found.left)])
        whole = np.block(
            [[at**2 * m + at * c + k, columns], [rows, found.left @ m @ found.shapes.T]]
        )
        right, solution = np.concatenate(parts[:2]), np.concatenate(parts[2:])
        np.testing.assert_allclose(solution, np.linalg.solve(whole, right), rtol=1e-9)
