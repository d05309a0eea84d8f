"""Symmetries that halve a period:  S M S' = M and so on for C, K and forces,  S p = -p.

A body that looks the same in a mirror while its load changes sign has motions of the kind
q(t + T/2) = S q(t): periodic motions are then fixed points of half a period followed by S. A body
has such an S if its operators and forces say so; candidates are tried on random states.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np

from vibrom.term import Term

CLOSE = 1e-9  # of the largest value: what rounding leaves of an exact symmetry
GRID = 1e8  # to a body's length: places are compared as whole numbers
STATES = 16  # on which forces are tried


@dataclass(frozen=True)
class Symmetry:
    """(S q)_i = sign_i q_order_i."""

    order: np.ndarray  # (n,)
    sign: np.ndarray  # (n,) 1 or -1

    def __call__(self, q: np.ndarray) -> np.ndarray:
        """S q of q (n, *batch)."""
        return (q[self.order].T * self.sign).T

    def inside(self, matrix: np.ndarray) -> np.ndarray:
        """S A S' of A (n, n)."""
        return self(self(matrix).T).T


def candidates(place: np.ndarray | None, axis: np.ndarray | None, size: int) -> list[Symmetry]:
    """All displacements reversed; and, where it is known where the displacements (n, dim) [m] are
    and along which axis (n,) each is, mirror images about the middle of the body.
    """
    found = [Symmetry(np.arange(size), np.full(size, -1.0))]
    if place is None:
        return found
    low, high = place.min(axis=0), place.max(axis=0)
    middle = 0.5 * (low + high)
    at = np.rint((place - middle) / (high - low).max() * GRID).astype(np.int64)
    for flips in list(product((False, True), repeat=place.shape[1]))[1:]:
        image = np.where(flips, -at, at)
        here, there = (np.lexsort((*part.T, axis)) for part in (at, image))
        if np.array_equal(at[here], image[there]) and np.array_equal(axis[here], axis[there]):
            order = np.empty(size, np.int64)
            order[there] = here
            found.append(Symmetry(order, np.where(np.array(flips)[axis], -1.0, 1.0)))
    return found


def holds(symmetry: Symmetry, term: Term) -> bool:
    """Does S leave the body and its forces as they are and reverse its load?"""
    n = term.size

    def close(one: np.ndarray, other: np.ndarray) -> bool:
        return bool(np.abs(one - other).max() <= CLOSE * np.abs(other).max())

    for part in (term.mass, term.damping, term.stiffness):
        if part is not None and not close(symmetry.inside(part.toarray()), part.toarray()):
            return False
    if term.load is None or not close(symmetry(term.load), -term.load):
        return False
    if term.dead_load is not None and not close(symmetry(term.dead_load), term.dead_load):
        return False
    random = np.random.default_rng(0)
    size = np.geomspace(1e-3, 1e1, STATES)  # of the body's own metre: springs may have gaps
    q, v = (random.standard_normal((n, STATES)) * size for _ in range(2))
    for force in term.forces:
        kernel, image, own = force.kernels(STATES)[0], np.zeros_like(q), np.zeros_like(q)
        kernel(q, v, force.dofs, force.table, own)
        kernel(*map(np.ascontiguousarray, map(symmetry, (q, v))), force.dofs, force.table, image)
        turned = symmetry(own)
        if (np.abs(image - turned).max(axis=0) > CLOSE * np.abs(own).max(axis=0)).any():
            return False
    return True
