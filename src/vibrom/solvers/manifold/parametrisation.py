"""Direct parametrisation of invariant manifolds, to any order.

    q = W(z),    v = V(z),    z' = R(z)    in    M v' + C v + K q + f(q) = 0,    q' = v

in 2d coordinates z of d pairs of eigenvalues lambda. With s = sum_i a_i lambda_i, and a_a and b_a
what lower degrees contribute to (DW R)_a and (DV R)_a, each monomial z^a asks for

    V_a = s W_a + a_a + sum_i phi_i R_ia
    A(s) W_a = -f_a - M b_a - (s M + C) a_a - sum_i [(s + lambda_i) M + C] phi_i R_ia
    psi_i' [(C + lambda_i M) W_a + M V_a] = 0    for every i whose R_ia is not zero

Style `normal_form` has R_ia only where z^a resonates with z_i, |Im s - Im lambda_i| <= detuning
|lambda_i|; style `graph` has all of them, and z is then the spectral projection of the state.
Damping need not be proportional, nor K symmetric. Sources: Vizzaccaro, Opreni, Salles, Frangi,
Touze, Nonlinear Dynamics 110 (2022) 525; Jain and Haller, Nonlinear Dynamics 107 (2022) 1417.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import eigh
from scipy.sparse import coo_matrix, csr_matrix

from vibrom.solvers.full.modes import eigenmodes, linearised
from vibrom.solvers.manifold.bordered import Bordered
from vibrom.solvers.manifold.force import ForceSeries, potentials
from vibrom.solvers.manifold.masters import Masters, masters
from vibrom.solvers.manifold.monomials import Monomials, Pairs
from vibrom.solvers.manifold.pencil import Pencil
from vibrom.solvers.manifold.products import kept_of, schedule
from vibrom.solvers.threads import mapped, worth
from vibrom.term import SceneError, Term

STYLES = ("normal_form", "graph")


@dataclass(frozen=True)
class Manifold:
    """Coefficients of all monomials, those of a mirror included."""

    pencil: Pencil
    forces: tuple[ForceSeries, ...]
    masters: Masters
    monomials: Monomials
    displacement: np.ndarray  # W (l, n) complex
    velocity: np.ndarray  # V (l, n) complex
    dynamics: np.ndarray  # R (2d, l) complex

    def with_forces(self, order: int) -> Manifold:
        """The same series, of the forces to a lower order only."""
        kept = int(replace(self.monomials, order=order).kept.sum())
        return replace(self, forces=tuple(part.truncated(kept) for part in self.forces))

    def truncated(self, order: int) -> Manifold:
        """The same series to a lower order."""
        monomials = replace(self.monomials, order=order)
        size = len(monomials)
        return replace(
            self.with_forces(order),
            monomials=monomials,
            displacement=self.displacement[:size],
            velocity=self.velocity[:size],
            dynamics=self.dynamics[:, :size],
        )


def parametrise(
    term: Term,
    modes: tuple[int, ...],
    order: int,
    style: str = "normal_form",
    detuning: float = 0.1,
) -> Manifold:
    """The manifold of these modes, counted from one, about the rest state of the term."""
    rest, stiffness = linearised(term)
    frequencies, shapes = _undamped(term, stiffness, max(modes))
    empty = csr_matrix((term.size, term.size))
    damping = empty if term.damping is None else term.damping
    pencil = Pencil(term.mass.tocsr(), damping.tocsr(), csr_matrix(stiffness))
    chosen = np.array(modes) - 1
    found = masters(pencil, frequencies[chosen], shapes[chosen])
    monomials = Monomials(order, found.mirror)
    forces = tuple(ForceSeries(part, rest, monomials) for part in potentials(term))
    return _Series(pencil, found, monomials, forces).run(style, detuning)


def _undamped(term: Term, stiffness: csr_matrix, count: int) -> tuple[np.ndarray, np.ndarray]:
    """`eigenmodes`; where nearly all modes are wanted its iteration has no room, and eigh has."""
    if count < term.size - 1:
        return eigenmodes(term, count)
    squares, vectors = eigh(stiffness.toarray(), term.mass.toarray())
    if not 0 < count <= term.size or squares[0] <= 0.0:
        raise SceneError(f"modes: the body has no mode {count} to oscillate in; choose others")
    return np.sqrt(squares[:count]), vectors.T[:count]


class _Series:
    """The coefficients as they are found, degree by degree."""

    def __init__(
        self,
        pencil: Pencil,
        found: Masters,
        monomials: Monomials,
        forces: tuple[ForceSeries, ...],
    ):
        self.pencil, self.masters, self.monomials, self.forces = pencil, found, monomials, forces
        l, n, pair = len(monomials), pencil.size, len(found.eigenvalues)
        self.w, self.v = np.zeros((l, n), complex), np.zeros((l, n), complex)
        self.r = np.zeros((pair, l), complex)
        self.sums = monomials.powers @ found.eigenvalues  # s of every monomial
        self.kept_place = np.cumsum(monomials.kept) - 1
        self.bordered = Bordered(pencil, found)

    def run(self, style: str, detuning: float) -> Manifold:
        self.w[: len(self.r)] = self.masters.shapes
        self.v[: len(self.r)] = self.masters.eigenvalues[:, None] * self.masters.shapes
        self.r[:, : len(self.r)] = np.diag(self.masters.eigenvalues)
        self._complete(kept_of(self.monomials, 1))
        resonant = self._resonances(style, detuning)
        for degree in range(2, self.monomials.order + 1):
            pairs = self.monomials.pairs(degree)
            targets = kept_of(self.monomials, degree)
            plan = schedule(self.monomials, degree, pairs)
            force = sum((part.next(plan) for part in self.forces), np.zeros((), complex))
            force = np.broadcast_to(force, (len(targets), self.pencil.size))
            mix = self._mixing(targets, pairs)
            a, b = mix @ self.w, mix @ self.v
            right = -force - (self.pencil.mass @ b.T).T - (self.pencil.damping @ a.T).T
            right -= self.sums[targets, None] * (self.pencil.mass @ a.T).T

            def solve(k: int, targets=targets, right=right, a=a) -> None:
                held = np.nonzero(resonant[:, targets[k]])[0]
                self._solve(int(targets[k]), right[k], a[k], held)

            mapped(solve, range(len(targets)), worth(self.pencil.size))
            self._complete(targets)
        return Manifold(
            self.pencil, self.forces, self.masters, self.monomials, self.w, self.v, self.r
        )

    def _resonances(self, style: str, detuning: float) -> np.ndarray:
        """(2d, l): has R_ia a place?"""
        if style == "graph":
            return np.ones(self.r.shape, bool)
        values = self.masters.eigenvalues[:, None]
        return np.abs(self.sums.imag - values.imag) <= detuning * np.abs(values)

    def _mixing(self, targets: np.ndarray, pairs: Pairs) -> csr_matrix:
        """(targets, l): what coefficients of lower degree contribute to DX R, R above degree 1."""
        raised, powers = self.monomials.raised, self.monomials.powers
        rows, columns, values = [], [], []
        for i in range(len(self.r)):
            # z^left is d z^c / dz_i without its factor c_i = left_i + 1; z^right is R's.
            rate = self.r[i, pairs.right]
            there = (rate != 0.0) & (pairs.right >= len(self.r))
            left = pairs.left[there]
            rows.append(np.searchsorted(targets, pairs.target[there]))
            columns.append(raised[i, left])
            values.append((powers[left, i] + 1) * rate[there])
        entries = np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))
        return coo_matrix(entries, shape=(len(targets), len(self.monomials))).tocsr()

    def _solve(self, target: int, f: np.ndarray, lower: np.ndarray, held: np.ndarray) -> None:
        """W, V and R of one monomial; `held` are the masters that it resonates with."""
        s, bordered = self.sums[target], self.bordered
        if len(held):
            border, g = bordered.at(s, held), -(bordered.left[0][held] @ lower)
            (w,), (rates,) = self.pencil.solve_bordered(s, f[None], g[None], border)
            self.r[held, target] = rates
            lower = lower + rates @ self.masters.shapes[held]
        else:
            (w,) = self.pencil.solve(s, f[None])
        self.w[target], self.v[target] = w, s * w + lower

    def _complete(self, targets: np.ndarray) -> None:
        """Hands the degree to the forces, and its mirrors to the coefficients."""
        for part in self.forces:
            part.complete(self.kept_place[targets], self.w[targets])
        mirrors, mirror = self.monomials.conjugate[targets], list(self.masters.mirror)
        self.w[mirrors], self.v[mirrors] = self.w[targets].conj(), self.v[targets].conj()
        self.r[:, mirrors] = self.r[np.ix_(mirror, targets)].conj()
