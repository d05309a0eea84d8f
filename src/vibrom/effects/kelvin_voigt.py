"""Damping by the material: stress from the rate of strain (Kelvin-Voigt), whatever the rotation.

    S = D : (E + tau E'),   E' = sym(F'H'),   H' = grad v
    V_ai = b tau int (F D : E')_iJ dN_a/dX_J dA  =  (C v)_ai + f_ai(q, v),   C = tau K

K is the elastic stiffness of the undeformed body, tau in s. Small motions of frequency omega are
damped by zeta = tau omega/2, as by `rayleigh_damping.stiffness_factor` = tau; but K v damps rigid
rotations of a body that has turned, and here these cost nothing: E' vanishes with them. The power
b int E' : D tau : E' dA is never negative. Without `geometric_nonlinearity` the body is linear, and
C is all.

Source: Belytschko, Liu, Moran, Nonlinear Finite Elements for Continua and Structures, chapter 5.
f is cubic in q and v together; methods that need forces of displacements alone refuse it.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np
from skfem.models.elasticity import linear_elasticity

from vibrom.bodies.space import Space
from vibrom.config.kinds import Positive
from vibrom.kernels.elements import complete_whole, gather, scatter, scatter_tangent
from vibrom.kernels.kelvin_voigt import added_rate_stress, rate_elasticity
from vibrom.kernels.lanes import WIDTH, fill, get, put, stack
from vibrom.kernels.saint_venant_kirchhoff import (
    add_blocks,
    add_share,
    gradient,
    moduli,
    slope,
    table_of,
)
from vibrom.term import Force, Term, force_kernel, tangent_kernel

STAGE = "damping"
ONCE = np.ones(16)  # as many as states are ever side by side


@dataclass(frozen=True)
class KelvinVoigt:
    retardation_time: Positive  # s, tau

    def assemble(self, space: Space, base: Term) -> Term:
        elastic = self.retardation_time * base.require("elastic", "kelvin_voigt", "elasticity")
        form = linear_elasticity(elastic[0, 1], elastic[-1, -1])
        damping = space.matrix(form.assemble(space.basis))
        if not any(_is_elastic(force, space) for force in base.forces):
            return Term(damping=damping)
        gradients = np.stack([shape[0].grad for shape in space.scalar.basis])
        table = table_of(elastic, space.scalar.dx, gradients)
        shapes, dim, elements, points = gradients.shape
        # Elements that are not there fill the last lanes: clamped and without weight.
        missing = -elements % WIDTH
        force = Force(
            lambda states: _kernels(dim, shapes, points, states),
            np.pad(space.element_dofs, ((0, missing), (0, 0)), constant_values=-1),
            np.ascontiguousarray(np.pad(table, ((0, missing), (0, 0))).T),
            symmetric=False,
            conservative=False,
        )
        return Term(damping=damping, forces=(force,))


def _is_elastic(force: Force, space: Space) -> bool:
    """Is it the nonlinear part of the body's own elasticity?"""
    elements = len(space.element_dofs)
    return force.conservative and np.array_equal(force.dofs[:elements], space.element_dofs)


@cache
def _kernels(dim: int, shapes: int, points: int, states: int):
    width, together = (WIDTH, WIDTH) if states == 1 else (states, 1)
    free, rows, stride = shapes - 1, dim * shapes, dim * (shapes - 1) + 3
    entries = rows * rows

    @force_kernel
    def force(q, v, dofs, table, f):
        u, rate, g = stack(rows, width), stack(rows, width), stack(rows, width)
        for e in range(0, dofs.shape[0], together):
            gather(q, 0, dofs, e, u, dim, states, width)
            gather(v, 0, dofs, e, rate, dim, states, width)
            for a in range(rows):
                put(g, a, fill(0.0, width))
            for number in range(points):
                point = number * stride, e
                h = gradient(u, table, point, free, dim, states, width)
                k = gradient(rate, table, point, free, dim, states, width)
                p = added_rate_stress(moduli(table, point, states), h, k)
                for a in range(free):
                    add_share(g, p, slope(table, point, a, dim, states), a, width)
            for a in range(dim * free):
                last = dim * free + a % dim
                put(g, last, get(g, last, width) - get(g, a, width))
            scatter(g, dofs, e, f, states, width)

    @tangent_kernel
    def tangent(q, v, dofs, table, slots, scale_q, scale_v, values):
        u, rate, ke = stack(rows, width), stack(rows, width), stack(entries, width)
        for e in range(0, dofs.shape[0], together):
            gather(q, 0, dofs, e, u, dim, states, width)
            gather(v, 0, dofs, e, rate, dim, states, width)
            if states == 1:
                by_q, by_v = fill(scale_q[0], width), fill(scale_v[0], width)
            else:
                by_q, by_v = get(scale_q, 0, width), get(scale_v, 0, width)
            for number in range(entries):
                put(ke, number, fill(0.0, width))
            for number in range(points):
                point = number * stride, e
                h = gradient(u, table, point, free, dim, states, width)
                k = gradient(rate, table, point, free, dim, states, width)
                a_ij = rate_elasticity(moduli(table, point, states), h, k, by_q, by_v)
                add_blocks(a_ij, ke, table, point, free, dim, states, width)
            complete_whole(ke, free, dim, width)
            scatter_tangent(ke, slots, e, ONCE, values, states, width)

    return force, tangent
