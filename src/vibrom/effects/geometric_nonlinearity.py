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
    PAIRS,
    add_force,
    add_mean_tangent,
    add_tangent,
    gradient,
    quadratic_strains,
    table_of,
    unstrained,
)
from vibrom.term import Force, Quartic, Term, force_kernel, tangent_kernel

STAGE = "forces"
TOGETHER = 1000  # elements whose stiffness is integrated at once, which bounds the memory


@dataclass(frozen=True)
class GeometricNonlinearity:
    def assemble(self, space: Space, base: Term) -> Term:
        elastic = base.require("elastic", "geometric_nonlinearity", "elasticity")
        weights = space.scalar.dx  # (elements, points) [m^2, m^3]
        gradients = np.stack(
            [shape[0].grad for shape in space.scalar.basis]
        )  # (shapes, dim, elements, points) [1/m]
        shapes, dim, elements, points = gradients.shape
        geometry = table_of(elastic, weights, gradients)
        stiffness = [
            _linear_stiffness(elastic, weights[some], gradients[:-1, :, some])
            for some in np.array_split(np.arange(elements), -(-elements // TOGETHER))
        ]
        table = np.concatenate([geometry, np.concatenate(stiffness)], axis=1)
        # Elements that are not there fill the last lanes: clamped and without weight.
        missing = -elements % WIDTH
        dofs = np.pad(space.element_dofs, ((0, missing), (0, 0)), constant_values=-1)
        return Term(
            forces=(
                Force(
                    partial(_kernels, dim, shapes, points),
                    dofs,
                    np.ascontiguousarray(np.pad(table, ((0, missing), (0, 0))).T),
                    quartic=lambda: (_potential(space, elastic, gradients),),
                    mean=partial(_mean_kernels, dim, shapes, points),
                ),
            )
        )


def _linear_stiffness(
    elastic: np.ndarray, weights: np.ndarray, gradients: np.ndarray
) -> np.ndarray:
    """(elements, d(d+1)/2) lower triangles, row by row, of the elements' linear stiffness [N/m]."""
    shapes, dim = gradients.shape[:2]
    b = np.zeros((len(elastic), dim * shapes, *weights.shape))
    for strain, (i, j) in enumerate(PAIRS[dim]):
        b[strain, i::dim] = gradients[:, j]
        b[strain, j::dim] = gradients[:, i]
    full = np.einsum("iaek,ij,jbek,ek->eab", b, elastic, b, weights, optimize=True)
    return full[:, *np.tril_indices(dim * shapes)]


def _potential(space: Space, elastic: np.ndarray, gradients: np.ndarray) -> Quartic:
    """U = int E' D E/2 dA  with  y = H by rows  and  e = (E_11, E_22, 2 E_12), in the order of
    PAIRS.
    """
    shapes, dim, elements, points = gradients.shape
    rows, columns, values = [], [], []
    at = np.arange(elements * points).reshape(elements, points)
    for a, i, j in np.ndindex(shapes, dim, dim):
        dofs = np.broadcast_to(space.element_dofs[:, dim * a + i, None], at.shape)
        free = dofs >= 0
        rows.append((at + (dim * i + j) * at.size)[free])
        columns.append(dofs[free])
        values.append(gradients[a, j][free])
    entries = np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))
    strains, size = len(elastic), dim * dim
    linear, square = np.zeros((strains, size)), np.zeros((strains, size, size))
    for strain, (j, k) in enumerate(PAIRS[dim]):
        linear[strain, dim * j + k] = linear[strain, dim * k + j] = 1.0
        for i in range(dim):
            square[strain, dim * i + j, dim * i + k] += 0.5
            square[strain, dim * i + k, dim * i + j] += 0.5
    square[:dim] *= 0.5
    local = csr_matrix(entries, shape=(size * at.size, space.size))
    return Quartic(local, space.scalar.dx.reshape(-1), linear, square, elastic)


@cache
def _kernels(dim: int, shapes: int, points: int, states: int):
    return _force(dim, shapes, points, 0, states), _tangent(dim, shapes, points, states)


@cache
def _mean_kernels(dim: int, shapes: int, points: int, states: int):
    return _force(dim, shapes, points, 1, states), _mean_tangent(dim, shapes, points, states)


def _force(dim: int, shapes: int, points: int, mean: int, states: int):
    width, together = (WIDTH, WIDTH) if states == 1 else (states, 1)
    free, rows, stride = shapes - 1, dim * shapes, dim * (shapes - 1) + 3

    @force_kernel
    def force(q, v, dofs, table, f):
        u, half, g = stack(rows, width), stack(rows, width), stack(rows, width)
        for e in range(0, dofs.shape[0], together):
            gather(q, 0, dofs, e, u, dim, states, width)
            if mean == 1:
                gather(q, v.shape[0], dofs, e, half, dim, states, width)
            for a in range(rows):
                put(g, a, fill(0.0, width))
            for number in range(points):
                point = number * stride, e
                more = unstrained(fill(-0.0, width), dim)  # zero would change the sign of -0
                if mean == 1:
                    more = quadratic_strains(gradient(half, table, point, free, dim, states, width))
                add_force(u, more, g, table, point, dim, states, width)
            for a in range(dim * free):
                last = dim * free + a % dim
                put(g, last, get(g, last, width) - get(g, a, width))
            scatter(g, dofs, e, f, states, width)

    return force


def _tangent(dim: int, shapes: int, points: int, states: int):
    width, together = (WIDTH, WIDTH) if states == 1 else (states, 1)
    free, rows, stride = shapes - 1, dim * shapes, dim * (shapes - 1) + 3
    entries, of_free = rows * (rows + 1) // 2, dim * free * (dim * free + 1) // 2

    @tangent_kernel
    def tangent(q, v, dofs, table, slots, scale_q, scale_v, values):
        u, ke = stack(rows, width), stack(entries, width)
        for e in range(0, dofs.shape[0], together):
            gather(q, 0, dofs, e, u, dim, states, width)
            for number in range(of_free):  # less the linear part
                put(ke, number, 0.0 - entry(table, points * stride + number, e, states))
            for number in range(of_free, entries):
                put(ke, number, fill(0.0, width))
            for number in range(points):
                add_tangent(u, ke, table, (number * stride, e), free, dim, states, width)
            complete(ke, free, dim, width)
            scatter_tangent(ke, slots, e, scale_q, values, states, width)

    return tangent


def _mean_tangent(dim: int, shapes: int, points: int, states: int):
    width, together = (WIDTH, WIDTH) if states == 1 else (states, 1)
    free, rows, stride = shapes - 1, dim * shapes, dim * (shapes - 1) + 3
    entries = rows * rows

    @tangent_kernel
    def mean_tangent(q, v, dofs, table, slots, scale_q, scale_v, values):
        u, half, ke = stack(rows, width), stack(rows, width), stack(entries, width)
        for e in range(0, dofs.shape[0], together):
            gather(q, 0, dofs, e, u, dim, states, width)
            gather(q, v.shape[0], dofs, e, half, dim, states, width)
            for row in range(dim * free):  # less the linear part
                for column in range(dim * free):
                    high, low = max(row, column), min(row, column)
                    number = points * stride + high * (high + 1) // 2 + low
                    put(ke, row * rows + column, 0.0 - entry(table, number, e, states))
            for number in range(points):
                point = number * stride, e
                add_mean_tangent(u, half, ke, table, point, dim, states, width)
            complete_whole(ke, free, dim, width)
            scatter_tangent(ke, slots, e, scale_q, values, states, width)

    return mean_tangent
