"""Newmark steps with a sparse direct factorisation, for matrices whose band is too wide: the same
equations, one state at a time.

The compiled element kernels are those of the banded loop; only the tangent's storage and its
factorisation differ: MKL's PARDISO where the package pypardiso is installed, SciPy's SuperLU
otherwise. Static solves assemble their tangent by the same class.
"""

from __future__ import annotations

import time

import numpy as np
from scipy.sparse import coo_matrix, csc_matrix, triu
from scipy.sparse.linalg import splu

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
        self.upper = triu(matrix.T, format="csr")
        self._run(self.phase, np.zeros((matrix.shape[0], 1)))
        self.phase = self.FACTORISE
        return self

    def solve(self, b: np.ndarray) -> np.ndarray:
        return self._run(self.SOLVE, np.asfortranarray(b))

    def _run(self, phase: int, b: np.ndarray) -> np.ndarray:
        self.solver.set_phase(phase)
        return self.solver._call_pardiso(self.upper, b)


class Tangent:
    """scale_a M + scale_v C + scale_q (K + df/dq) in one fixed pattern, into which the element
    kernels add.
    """

    def __init__(self, term: Term, scale_a: float, scale_v: float, scale_q: float):
        self.n, self.forces = term.size, term.forces
        self.symmetric = all(force.symmetric for force in term.forces)
        self.pardiso = Pardiso() if PyPardisoSolver and self.symmetric else None
        self.scale_q, self.scale_v = np.array([scale_q]), np.array([scale_v])
        linear = [
            (coo_matrix(part), scale)
            for part, scale in (
                (term.mass, scale_a),
                (term.damping, scale_v),
                (term.stiffness, scale_q),
            )
            if part is not None
        ]
        entries = [self._entries(force) for force in term.forces]
        # An entry's key orders the matrix by columns; a symmetric force names its lower triangle,
        # and the upper one mirrors it.
        keys = [part.col.astype(np.int64) * self.n + part.row for part, _ in linear] + [
            pair[pair >= 0] for pair in entries
        ]
        keys = np.unique(np.concatenate([*keys, *(self._mirror(key) for key in keys)]))
        self.base = np.zeros(len(keys))
        for part, scale in linear:
            np.add.at(
                self.base,
                np.searchsorted(keys, part.col.astype(np.int64) * self.n + part.row),
                scale * part.data,
            )
        self.slots = tuple(
            np.ascontiguousarray(np.where(pair >= 0, np.searchsorted(keys, pair), -1))
            for pair in entries
        )
        row, column = keys % self.n, keys // self.n
        self.lower = np.searchsorted(
            keys, np.minimum(row, column) * self.n + np.maximum(row, column)
        )
        self.row, self.start = row, np.searchsorted(column, np.arange(self.n + 1))

    def _entries(self, force: Force) -> np.ndarray:
        d = force.dofs.shape[1]
        rows, columns = (
            force.dofs[:, index]
            for index in (np.tril_indices(d) if force.symmetric else np.divmod(np.arange(d * d), d))
        )
        if force.symmetric:
            rows, columns = np.maximum(rows, columns), np.minimum(rows, columns)
        return np.where(np.minimum(rows, columns) >= 0, columns * self.n + rows, -1)

    def _mirror(self, keys: np.ndarray) -> np.ndarray:
        return keys % self.n * self.n + keys // self.n

    def at(self, q: np.ndarray, v: np.ndarray) -> csc_matrix:
        """The matrix (n, n) at the state q, v (n, 1)."""
        lower, values = np.zeros((len(self.base), 1)), self.base[:, None].copy()
        for force, slots in zip(self.forces, self.slots):
            force.kernels(1)[1](
                q,
                v,
                force.dofs,
                force.table,
                slots,
                self.scale_q,
                self.scale_v,
                lower if force.symmetric else values,
            )
        return csc_matrix(
            (values[:, 0] + lower[self.lower, 0], self.row, self.start), shape=(self.n, self.n)
        )

    def factor(self, q: np.ndarray, v: np.ndarray):
        """Its factor; the mass makes a symmetric one positive definite, which needs no pivots."""
        if not self.symmetric:
            return splu(self.at(q, v))
        return (
            self.pardiso(self.at(q, v))
            if self.pardiso
            else splu(self.at(q, v), permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})
        )


def run(
    settings,
    term: Term,
    half: int,
    q,
    v,
    h,
    signal,
    initial: str,
    record,
    out,
    where: slice,
    progress,
) -> None:
    """The counterpart of the banded run for one state: q, v (n, 1), h (1,) [s], signal (steps + 1,
    1).
    """
    started = time.perf_counter()
    gamma, beta = 0.5 + settings.alpha, 0.25 * (1.0 + settings.alpha) ** 2
    scale_q, scale_v = beta * h**2, gamma * h
    tangent = Tangent(term, 1.0, float(scale_v[0]), float(scale_q[0]))
    kernels = [force.kernels(1) for force in term.forces]
    load, dead = (
        np.zeros((len(q), 1)) if part is None else part[:, None]
        for part in (term.load, term.dead_load)
    )

    def internal(q, v):
        f = np.zeros_like(q) if term.stiffness is None else term.stiffness @ q
        f = np.ascontiguousarray(f)
        for force, (kernel, _) in zip(term.forces, kernels):
            kernel(q, v, force.dofs, force.table, f)
        return f

    def inertial(a, v):
        return term.mass @ a + (0.0 if term.damping is None else term.damping @ v)

    a = np.zeros_like(q)
    if initial == "equilibrium":
        a = splu(term.mass.tocsc()).solve(load * signal[0] + dead - inertial(a, v) - internal(q, v))
    factor, index, before = None, where.start, a

    def keep(step):
        if step >= record.start and (step - record.start) % record.every == 0:
            slot = (step - record.start) // record.every
            (
                out.displacement[index, slot],
                out.velocity[index, slot],
                out.acceleration[index, slot],
            ) = q[:, 0], v[:, 0], a[:, 0]
        if step >= record.probe_start:
            out.probes[index, :, step - record.probe_start] = q[record.probes, 0]

    keep(0)
    for step in range(1, len(signal)):
        guess = 2.0 * a - before
        q = q + h * v + h**2 * ((0.5 - beta) * a + beta * guess)
        v = v + h * ((1.0 - gamma) * a + gamma * guess)
        before, a, previous = a, guess, np.inf
        external = load * signal[step] + dead
        for iteration in range(settings.max_iterations + 1):
            body, spring = inertial(a, v), internal(q, v)
            r = external - body - spring
            norm = np.linalg.norm(r)
            if iteration == 0:
                scale = np.linalg.norm(body) + np.linalg.norm(spring) + np.linalg.norm(external)
            converged = norm <= settings.tolerance * scale
            if (
                (converged and iteration > 0)
                or iteration == settings.max_iterations
                or not np.isfinite(norm)
            ):
                break
            slow = (
                iteration > 0
                and norm * (norm / previous) ** settings.patience > settings.tolerance * scale
            )
            if factor is None or (slow and term.forces):
                factor = tangent.factor(q, v)
                out.factorisations += 1
            previous, change = norm, factor.solve(r)
            out.iterations += 1
            a, v, q = a + change, v + scale_v * change, q + scale_q * change
        if not converged:
            out.failed_at[index] = step
            break
        keep(step)
        if progress is not None:
            progress(1)
    out.seconds += time.perf_counter() - started
