"""Newmark steps with a sparse direct factorisation, for matrices whose band is too wide: the same equations, one state at a time.

The compiled element kernels are those of the banded loop; only the tangent's storage and its factorisation (SuperLU) differ.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_matrix, csc_matrix
from scipy.sparse.linalg import splu

from vibrom.term import Term


class Tangent:
    """M + scale_v C + scale_q (K + df/dq), symmetric; the element kernels add into the lower triangle of one fixed pattern."""

    def __init__(self, term: Term, scale_q: float, scale_v: float):
        n = term.mass.shape[0]
        linear = coo_matrix(term.mass)
        for part, scale in ((term.damping, scale_v), (term.stiffness, scale_q)):
            if part is not None:
                linear = coo_matrix(linear + scale * part)
        pairs = [self._entries(force.dofs, n) for force in term.forces]
        keep = linear.row >= linear.col
        linear_keys = linear.row[keep].astype(np.int64) * n + linear.col[keep]
        keys = np.unique(np.concatenate([linear_keys, *(pair[pair >= 0] for pair in pairs)]))
        self.base = np.zeros(len(keys))
        np.add.at(self.base, np.searchsorted(keys, linear_keys), linear.data[keep])
        self.slots = tuple(np.ascontiguousarray(np.where(pair >= 0, np.searchsorted(keys, pair), -1)) for pair in pairs)
        self.row, self.column, self.n = keys // n, keys % n, n

    @staticmethod
    def _entries(dofs: np.ndarray, n: int) -> np.ndarray:
        rows, columns = (dofs[:, index] for index in np.tril_indices(dofs.shape[1]))
        return np.where(np.minimum(rows, columns) >= 0, np.maximum(rows, columns) * n + np.minimum(rows, columns), -1)

    def factorise(self, values: np.ndarray):
        lower = csc_matrix((values, (self.row, self.column)), shape=(self.n, self.n))
        strict = self.row != self.column
        upper = csc_matrix((values[strict], (self.column[strict], self.row[strict])), shape=(self.n, self.n))
        return splu((lower + upper).tocsc(), permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})


def run(settings, term: Term, half: int, q, v, h, signal, initial: str, record, out, where: slice, progress) -> None:
    """The counterpart of the banded run for one state: q, v (n, 1), h (1,) [s], signal (steps + 1, 1)."""
    gamma, beta = 0.5 + settings.alpha, 0.25 * (1.0 + settings.alpha) ** 2
    scale_q, scale_v = beta * h**2, gamma * h
    tangent = Tangent(term, float(scale_q[0]), float(scale_v[0]))
    kernels = [force.kernels(1) for force in term.forces]
    load = np.zeros(len(q)) if term.load is None else term.load

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
        a = splu(term.mass.tocsc()).solve(load[:, None] * signal[0] - inertial(a, v) - internal(q, v))
    factor, index, before = None, where.start, a

    def keep(step):
        if step >= record.start and (step - record.start) % record.every == 0:
            slot = (step - record.start) // record.every
            out.displacement[index, slot], out.velocity[index, slot], out.acceleration[index, slot] = q[:, 0], v[:, 0], a[:, 0]
        if step >= record.probe_start:
            out.probes[index, :, step - record.probe_start] = q[record.probes, 0]

    keep(0)
    for step in range(1, len(signal)):
        guess = 2.0 * a - before
        q = q + h * v + h**2 * ((0.5 - beta) * a + beta * guess)
        v = v + h * ((1.0 - gamma) * a + gamma * guess)
        before, a, previous = a, guess, np.inf
        external = load[:, None] * signal[step]
        for iteration in range(settings.max_iterations + 1):
            body, spring = inertial(a, v), internal(q, v)
            r = external - body - spring
            norm = np.linalg.norm(r)
            if iteration == 0:
                scale = np.linalg.norm(body) + np.linalg.norm(spring) + np.linalg.norm(external)
            converged = norm <= settings.tolerance * scale
            if (converged and iteration > 0) or iteration == settings.max_iterations or not np.isfinite(norm):
                break
            if factor is None or (iteration > 0 and norm > settings.refresh * previous and term.forces):
                values = tangent.base[:, None].copy()
                for force, (_, kernel), slots in zip(term.forces, kernels, tangent.slots):
                    kernel(q, v, force.dofs, force.table, slots, scale_q, scale_v, values)
                factor = tangent.factorise(values[:, 0])
                out.factorisations += 1
            previous, change = norm, factor.solve(r)
            out.iterations += 1
            a, v, q = a + change, v + scale_v * change, q + scale_q * change
        if not converged:
            out.failed_at[index] = step
            return
        keep(step)
        if progress is not None:
            progress(1)
