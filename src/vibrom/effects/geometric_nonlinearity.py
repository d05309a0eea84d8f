"""What the St. Venant-Kirchhoff material adds to linear elasticity (total Lagrangian).

    H = grad u,  F = I + H,  E = (H + H' + H'H)/2,  S = D : E,
    f_ai = b int (F S - D : eps)_iJ dN_a/dX_J dA,
    df_ai/du_bj = b int dN_a/dX_J A_iJ,jL dN_b/dX_L dA - K_ai,bj,   A_iJ,jL = F_iI F_jK D_IJ,KL +
    delta_ij S_JL  (the first elasticity tensor).

Source: Belytschko, Liu, Moran, Nonlinear Finite Elements for Continua and Structures, chapter 4.
The linear part is taken out inside the integrand, so that small motions lose no digits. Kernels are
compiled for a number of shape functions, quadrature points and states side by side.

The mean force over a step has F at its middle and the stress of the mean strain of both ends, which
is that of the middle and the quadratic part of the strain that half the way would make alone. As
the energy is quadratic in the strain, it does the work of the energy; as the stress is symmetric,
it has no moment (Simo and Tarnow, ZAMP 43 (1992) 757). Its derivative by the end of the step, at a
fixed start, has F at the middle on one side and at the end on the other.
"""

from dataclasses import dataclass
from functools import cache, partial

import numpy as np
from scipy.sparse import csr_matrix

from vibrom.bodies.space import Space
from vibrom.kernels.elements import complete, complete_whole, gather, scatter, scatter_tangent
from vibrom.kernels.lanes import WIDTH, entry, fill, get, put, stack
from vibrom.kernels.saint_venant_kirchhoff import (
    add_force,
    add_mean_tangent,
    add_tangent,
    gradient,
    quadratic_strains,
)
from vibrom.term import Force, Quartic, Term, force_kernel, tangent_kernel

STAGE = "forces"


@dataclass(frozen=True)
class GeometricNonlinearity:
    def assemble(self, space: Space, base: Term) -> Term:
        elastic = base.require("elastic", "geometric_nonlinearity", "elasticity")
        weights = space.scalar.dx  # (elements, points) [m^2]
        gradients = np.stack(
            [shape[0].grad for shape in space.scalar.basis]
        )  # (shapes, 2, elements, points) [1/m]
        shapes, _, elements, points = gradients.shape
        # Rigid motion changes nothing: the shape functions add up to one, and the last one's part
        # is minus the sum of the others'.
        moduli = weights * np.array([elastic[0, 0], elastic[0, 1], elastic[2, 2]])[:, None, None]
        geometry = np.concatenate(
            [moduli, gradients[:-1].reshape(2 * (shapes - 1), elements, points)]
        ).transpose(1, 2, 0)
        table = np.concatenate(
            [geometry.reshape(elements, -1), _linear_stiffness(elastic, weights, gradients[:-1])],
            axis=1,
        )
        # Elements that are not there fill the last lanes: clamped and without weight.
        missing = -elements % WIDTH
        dofs = np.pad(space.element_dofs, ((0, missing), (0, 0)), constant_values=-1)
        return Term(
            forces=(
                Force(
                    partial(_kernels, shapes, points),
                    dofs,
                    np.ascontiguousarray(np.pad(table, ((0, missing), (0, 0))).T),
                    quartic=lambda: (_potential(space, elastic, gradients),),
                    mean=partial(_mean_kernels, shapes, points),
                ),
            )
        )


def _linear_stiffness(
    elastic: np.ndarray, weights: np.ndarray, gradients: np.ndarray
) -> np.ndarray:
    """(elements, d(d+1)/2) lower triangles, row by row, of the elements' linear stiffness [N/m]."""
    shapes = len(gradients)
    b = np.zeros((3, 2 * shapes, *weights.shape))
    b[0, 0::2], b[1, 1::2] = gradients[:, 0], gradients[:, 1]
    b[2, 0::2], b[2, 1::2] = gradients[:, 1], gradients[:, 0]
    full = np.einsum("iaek,ij,jbek,ek->eab", b, elastic, b, weights, optimize=True)
    return full[:, *np.tril_indices(2 * shapes)]


def _potential(space: Space, elastic: np.ndarray, gradients: np.ndarray) -> Quartic:
    """U = int E' D E/2 dA  with  y = (H_11, H_12, H_21, H_22)  and  e = (E_11, E_22, 2 E_12)."""
    shapes, _, elements, points = gradients.shape
    rows, columns, values = [], [], []
    at = np.arange(elements * points).reshape(elements, points)
    for a, i, j in np.ndindex(shapes, 2, 2):
        dofs = np.broadcast_to(space.element_dofs[:, 2 * a + i, None], at.shape)
        free = dofs >= 0
        rows.append((at + (2 * i + j) * at.size)[free])
        columns.append(dofs[free])
        values.append(gradients[a, j][free])
    entries = np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))
    linear = np.array([[1.0, 0, 0, 0], [0, 0, 0, 1.0], [0, 1.0, 1.0, 0]])
    square = np.zeros((3, 4, 4))
    for i in range(2):
        for strain, (j, k) in enumerate(((0, 0), (1, 1), (0, 1))):
            square[strain, 2 * i + j, 2 * i + k] += 0.5
            square[strain, 2 * i + k, 2 * i + j] += 0.5
    square[:2] *= 0.5
    moduli = np.zeros((3, 3))
    moduli[:2, :2], moduli[2, 2] = elastic[:2, :2], elastic[2, 2]
    local = csr_matrix(entries, shape=(4 * at.size, space.size))
    return Quartic(local, space.scalar.dx.reshape(-1), linear, square, moduli)


@cache
def _kernels(shapes: int, points: int, states: int):
    return _force(shapes, points, 0, states), _tangent(shapes, points, states)


@cache
def _mean_kernels(shapes: int, points: int, states: int):
    return _force(shapes, points, 1, states), _mean_tangent(shapes, points, states)


def _force(shapes: int, points: int, mean: int, states: int):
    width, together = (WIDTH, WIDTH) if states == 1 else (states, 1)
    free, rows, stride = shapes - 1, 2 * shapes, 2 * shapes + 1

    @force_kernel
    def force(q, v, dofs, table, f):
        u, half, g = stack(rows, width), stack(rows, width), stack(rows, width)
        for e in range(0, dofs.shape[0], together):
            gather(q, 0, dofs, e, u, states, width)
            if mean == 1:
                gather(q, v.shape[0], dofs, e, half, states, width)
            for a in range(rows):
                put(g, a, fill(0.0, width))
            for point in range(points):
                at, nothing = point * stride, fill(-0.0, width)  # zero would change the sign of -0
                more = nothing, nothing, nothing
                if mean == 1:
                    more = quadratic_strains(gradient(half, table, at, e, free, states, width))
                add_force(u, more, g, table, at, e, states, width)
            for a in range(2 * free):
                put(g, 2 * free + a % 2, get(g, 2 * free + a % 2, width) - get(g, a, width))
            scatter(g, dofs, e, f, states, width)

    return force


def _tangent(shapes: int, points: int, states: int):
    width, together = (WIDTH, WIDTH) if states == 1 else (states, 1)
    free, rows, stride = shapes - 1, 2 * shapes, 2 * shapes + 1
    entries, of_free = shapes * (2 * shapes + 1), free * (2 * free + 1)

    @tangent_kernel
    def tangent(q, v, dofs, table, slots, scale_q, scale_v, values):
        u, ke = stack(rows, width), stack(entries, width)
        for e in range(0, dofs.shape[0], together):
            gather(q, 0, dofs, e, u, states, width)
            for number in range(of_free):  # less the linear part
                put(ke, number, 0.0 - entry(table, points * stride + number, e, states))
            for number in range(of_free, entries):
                put(ke, number, fill(0.0, width))
            for point in range(points):
                add_tangent(u, ke, table, point * stride, e, free, states, width)
            complete(ke, free, width)
            scatter_tangent(ke, slots, e, scale_q, values, states, width)

    return tangent


def _mean_tangent(shapes: int, points: int, states: int):
    width, together = (WIDTH, WIDTH) if states == 1 else (states, 1)
    free, rows, stride, entries = shapes - 1, 2 * shapes, 2 * shapes + 1, 4 * shapes * shapes

    @tangent_kernel
    def mean_tangent(q, v, dofs, table, slots, scale_q, scale_v, values):
        u, half, ke = stack(rows, width), stack(rows, width), stack(entries, width)
        for e in range(0, dofs.shape[0], together):
            gather(q, 0, dofs, e, u, states, width)
            gather(q, v.shape[0], dofs, e, half, states, width)
            for row in range(2 * free):  # less the linear part
                for column in range(2 * free):
                    high, low = max(row, column), min(row, column)
                    number = points * stride + high * (high + 1) // 2 + low
                    put(ke, row * rows + column, 0.0 - entry(table, number, e, states))
            for point in range(points):
                add_mean_tangent(u, half, ke, table, point * stride, e, states, width)
            complete_whole(ke, free, width)
            scatter_tangent(ke, slots, e, scale_q, values, states, width)

    return mean_tangent
