"""What effects add up to:  M a + C v + K q + sum_i f_i(q, v) = p u(t) + p_0.

A Term holds the parts that are there; a part that no effect brings is None (or no force), never a
zero matrix. Terms add with `+`. M, C and K are symmetric. Forces vanish at rest, f_i(0, 0) = 0:
what acts on the undeformed body at all times is the dead load p_0.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numba import types
from scipy.sparse import csr_matrix

from vibrom.kernels.compiled import Places, Rows, Vector, kernel, machine_type

# f (n, width) += f_e(q, v)
# values (slots, width) += scale_q df_e/dq + scale_v df_e/dv: of each element of a symmetric force
# the lower triangle, row by row, of a non-symmetric one the whole matrix.
_states, _index, _scale = machine_type(Rows), machine_type(Places), machine_type(Vector)
FORCE = types.void(_states, _states, _index, _states, _states)
TANGENT = types.void(_states, _states, _index, _states, _index, _scale, _scale, _states)

# Compile `function(q, v, dofs, table, f)` and
# `function(q, v, dofs, table, slots, scale_q, scale_v, values)`; see docs/kernels.md.
force_kernel, tangent_kernel = kernel(FORCE), kernel(TANGENT)


class SceneError(ValueError):
    """A body or effects that do not go together; it names the key, the value and the cure."""


@dataclass(frozen=True)
class Quartic:
    """A potential that is a square of quadratic functions, at every point of a body, less what is
    quadratic in the displacements.

        U(q) = sum_points w/2 [e' D e - (L y)' D (L y)],    e = L y + Q(y, y),    y = B q
    """

    local: csr_matrix  # B (k points, n): row c points + j is component c of y at point j
    weight: np.ndarray  # w (points,)
    linear: np.ndarray  # L (m, k)
    square: np.ndarray  # Q (m, k, k), symmetric in the last two
    moduli: np.ndarray  # D (m, m), symmetric


@dataclass(frozen=True)
class Force:
    """A state-dependent force, element by element."""

    # width -> (force, tangent), compiled for `width` states side by side, the state index last
    kernels: Callable[[int], tuple[Callable, Callable]]
    dofs: np.ndarray  # (elements, d) free dof of each local dof, -1 where it is clamped
    table: np.ndarray  # what the kernels know of the elements
    # Its tangent kernel adds d(d+1)/2 entries an element (lower triangle, row by row); otherwise
    # d*d (row by row).
    symmetric: bool = True
    # Does it derive from a potential, so that its work is a change of energy?
    conservative: bool = True
    # gives the potentials that the force derives from, none of a force that is linear; None where
    # it is no cubic polynomial of the displacements
    quartic: Callable[[], tuple[Quartic, ...]] | None = None
    # width -> (force, tangent) of the mean force over a step, which does the work of its potential:
    # q is then (2n, width), the middle and, below it, half the way from start to end; the tangent
    # is d/dmiddle + d/dhalf, at a fixed start, and adds whole matrices. None: the force at the
    # middle is taken
    mean: Callable[[int], tuple[Callable, Callable]] | None = None

    def over_a_step(self) -> Force:
        """The mean force."""
        if self.mean is None:
            return self
        return replace(self, kernels=self.mean, symmetric=False)


@dataclass(frozen=True)
class Driven:
    """A load with a signal of its own:  p u(t)."""

    load: np.ndarray  # p (n,) N per unit of the signal
    signal: Mapping[str, Any]  # the settings of what u adds up from, by file of `vibrom.signals`


@dataclass(frozen=True)
class Term:
    """What some effects add to the equation of motion of n free displacements."""

    mass: csr_matrix | None = None  # M (n, n) kg
    damping: csr_matrix | None = None  # C (n, n) kg/s
    stiffness: csr_matrix | None = None  # K (n, n) N/m
    forces: tuple[Force, ...] = ()  # f_i, N
    load: np.ndarray | None = None  # p (n,) N per unit of the signal
    driven: tuple[Driven, ...] = ()  # loads that act where their own signals do
    dead_load: np.ndarray | None = None  # p_0 (n,) N
    # (3, 3) N/m: stress resultants (s11, s22, s12) over strains (e11, e22, 2 e12), thickness
    # included; of a body in space (6, 6) Pa, see `kernels/saint_venant_kirchhoff.py`
    elastic: np.ndarray | None = None
    # (n, dim) kg: the mass that a uniform acceleration along x, y (, z) moves, M times the rigid
    # translations, clamped dofs included
    carried: np.ndarray | None = None

    def __add__(self, other: Term) -> Term:
        """The sum, part by part."""

        def both(name: str):
            mine, theirs = getattr(self, name), getattr(other, name)
            return theirs if mine is None else mine if theirs is None else mine + theirs

        return Term(**{part.name: both(part.name) for part in fields(self)})

    @property
    def size(self) -> int:
        """n, the number of free displacements."""
        driven = [one.load for one in self.driven]
        for part in (self.mass, self.stiffness, self.damping, self.load, self.dead_load, *driven):
            if part is not None:
                return part.shape[0]
        raise SceneError("effects is empty: there is no body; list inertia and elasticity")

    def require(self, part: str, effect: str, brought_by: str):
        """The part of this name, or a SceneError that says which effect brings it."""
        value = getattr(self, part)
        if value is None:
            raise SceneError(
                f"effects.{effect} needs {part}, and no effect before it brings one; list "
                f"{brought_by} first"
            )
        return value
