"""The tangent of a body as a sparse matrix, and its factors.

    scale_a M + scale_v (C + df/dv) + scale_q (K + df/dq)

in one fixed pattern, into which the compiled element kernels add. Factors are MKL's PARDISO where
the package pypardiso is installed, those of `factors` otherwise.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_matrix, csc_matrix, triu

from vibrom.solvers.full.factors import factor
from vibrom.term import Force, Term

try:
    from pypardiso import PyPardisoSolver
except ImportError:
    PyPardisoSolver = None


class Pardiso:
    """Factors of symmetric matrices of one pattern, which is analysed once."""

    SYMMETRIC, ANALYSE_AND_FACTORISE, FACTORISE, SOLVE = -2, 12, 22, 33

    def __init__(self):
        self.solver, self.phase = PyPardisoSolver(mtype=self.SYMMETRIC), self.ANALYSE_AND_FACTORISE

    def __call__(self, matrix: csc_matrix) -> Pardiso:
        """This with the factor of a matrix."""
        self.upper = triu(matrix.T, format="csr")
        self._run(self.phase, np.zeros((matrix.shape[0], 1)))
        self.phase = self.FACTORISE
        return self

    def solve(self, b: np.ndarray) -> np.ndarray:
        """A^-1 b."""
        return self._run(self.SOLVE, np.asfortranarray(b))

    def _run(self, phase: int, b: np.ndarray) -> np.ndarray:
        self.solver.set_phase(phase)
        return self.solver._call_pardiso(self.upper, b)


class Tangent:
    """The tangent of a term for fixed scales, at any state."""

    def __init__(self, term: Term, scale_a: float, scale_v: float, scale_q: float):
        self.n, self.forces = term.size, term.forces
        self.symmetric = all(force.symmetric for force in term.forces)
        self.pardiso = Pardiso() if PyPardisoSolver and self.symmetric else None
        self.scale_q, self.scale_v = np.array([scale_q]), np.array([scale_v])
        scaled = ((term.mass, scale_a), (term.damping, scale_v), (term.stiffness, scale_q))
        linear = [(coo_matrix(part), scale) for part, scale in scaled if part is not None]
        entries = [self._entries(force) for force in term.forces]
        # An entry's key orders the matrix by columns; a symmetric force names its lower triangle,
        # and the upper one mirrors it.
        keys = [self._key(part.row, part.col) for part, _ in linear]
        keys += [each[each >= 0] for each in entries]
        keys = np.unique(np.concatenate([*keys, *(self._mirror(key) for key in keys)]))
        self.base = np.zeros(len(keys))
        for part, scale in linear:
            place = np.searchsorted(keys, self._key(part.row, part.col))
            np.add.at(self.base, place, scale * part.data)
        self.slots = tuple(
            np.ascontiguousarray(np.where(each >= 0, np.searchsorted(keys, each), -1))
            for each in entries
        )
        row, column = keys % self.n, keys // self.n
        lower = self._key(np.maximum(row, column), np.minimum(row, column))
        self.lower = np.searchsorted(keys, lower)
        self.row, self.start = row, np.searchsorted(column, np.arange(self.n + 1))

    def _key(self, row: np.ndarray, column: np.ndarray) -> np.ndarray:
        return column.astype(np.int64) * self.n + row

    def _entries(self, force: Force) -> np.ndarray:
        """Keys of the entries that a force's tangent kernel adds, -1 where a dof is clamped."""
        d = force.dofs.shape[1]
        local = np.tril_indices(d) if force.symmetric else np.divmod(np.arange(d * d), d)
        rows, columns = (force.dofs[:, index] for index in local)
        if force.symmetric:
            rows, columns = np.maximum(rows, columns), np.minimum(rows, columns)
        return np.where(np.minimum(rows, columns) >= 0, self._key(rows, columns), -1)

    def _mirror(self, keys: np.ndarray) -> np.ndarray:
        return keys % self.n * self.n + keys // self.n

    def at(self, q: np.ndarray, v: np.ndarray) -> csc_matrix:
        """The matrix (n, n) at the state q, v (n, 1); q of mean forces: see `Force.mean`."""
        lower, values = np.zeros((len(self.base), 1)), self.base[:, None].copy()
        for force, slots in zip(self.forces, self.slots):
            into = lower if force.symmetric else values
            add_tangent = force.kernels(1)[1]
            add_tangent(q, v, force.dofs, force.table, slots, self.scale_q, self.scale_v, into)
        total = values[:, 0] + lower[self.lower, 0]
        return csc_matrix((total, self.row, self.start), shape=(self.n, self.n))

    def factor(self, q: np.ndarray, v: np.ndarray):
        """The matrix at a state as a factor that has `solve`; a mass makes a symmetric one positive
        definite, which needs no pivots.
        """
        matrix = self.at(q, v)
        if self.pardiso:
            return self.pardiso(matrix)
        return factor(matrix, self.symmetric, pivots=False)
