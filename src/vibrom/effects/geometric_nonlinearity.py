"""What the St. Venant-Kirchhoff material adds to linear elasticity (total Lagrangian).

    H = grad u,  F = I + H,  E = (H + H' + H'H)/2,  S = D : E,
    f_ai = b int (F S - D : eps)_iJ dN_a/dX_J dA,
    df_ai/du_bj = b int dN_a/dX_J A_iJ,jL dN_b/dX_L dA - K_ai,bj,   A_iJ,jL = F_iI F_jK D_IJ,KL +
    delta_ij S_JL  (the first elasticity tensor).

Source: Belytschko, Liu, Moran, Nonlinear Finite Elements for Continua and Structures, chapter 4.
The linear part is taken out inside the integrand, so that small motions lose no digits. Kernels are
compiled for a number of shape functions, quadrature points and states side by side.
"""

from dataclasses import dataclass
from functools import cache, partial

import numpy as np
from numba.extending import register_jitable

from vibrom.bodies.space import Space
from vibrom.kernels.lanes import WIDTH, entry, fill, get, put, room
from vibrom.term import Force, Term, force_kernel, tangent_kernel

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


@register_jitable(fastmath=True)
def gather(q, dofs, e, u, states, width):
    """U (2 shapes, width): displacements of an element's nodes, all but the last told from the last
    one's. For one state alone, of elements e, e + 1, ...
    """
    last = u.shape[0] - 2
    for a in range(u.shape[0]):
        if states == 1:
            for lane in range(width):
                dof = dofs[e + lane, a]
                u[a, lane] = q[dof, 0] if dof >= 0 else 0.0
        else:
            dof = dofs[e, a]
            put(u, a, get(q, dof, width) if dof >= 0 else fill(0.0, width))
    for a in range(last):
        put(u, a, get(u, a, width) - get(u, last + a % 2, width))


@register_jitable(fastmath=True)
def gradient(u, table, at, e, free, states, width):
    """H at the point whose shape functions begin in row `at` of the table: H_11, H_12, H_21, H_22."""
    h0 = h1 = h2 = h3 = fill(0.0, width)
    for a in range(free):
        n0, n1 = entry(table, at + 2 * a, e, states), entry(table, at + 1 + 2 * a, e, states)
        ux, uy = get(u, 2 * a, width), get(u, 2 * a + 1, width)
        h0 += n0 * ux
        h1 += n1 * ux
        h2 += n0 * uy
        h3 += n1 * uy
    return h0, h1, h2, h3


@cache
def _kernels(shapes: int, points: int, states: int):
    return _force(shapes, points, states), _tangent(shapes, points, states)


def _force(shapes: int, points: int, states: int):
    """Lanes are states; for one state they are elements, and reading and adding go one by one."""
    stride, width, together, free = (
        3 + 2 * (shapes - 1),
        (WIDTH if states == 1 else states),
        (WIDTH if states == 1 else 1),
        shapes - 1,
    )

    @force_kernel
    def force(q, v, dofs, table, f):
        u, g = room(2 * shapes, width), room(2 * shapes, width)
        for e in range(0, dofs.shape[0], together):
            gather(q, dofs, e, u, states, width)
            for a in range(2 * shapes):
                put(g, a, fill(0.0, width))
            for k in range(points):
                at = k * stride
                d11, d12, d33 = (
                    entry(table, at, e, states),
                    entry(table, at + 1, e, states),
                    entry(table, at + 2, e, states),
                )
                h0, h1, h2, h3 = gradient(u, table, at + 3, e, free, states, width)
                e11, e22, e12 = (
                    0.5 * (h0 * h0 + h2 * h2),
                    0.5 * (h1 * h1 + h3 * h3),
                    h0 * h1 + h2 * h3,
                )
                r11, r22, r12 = d11 * e11 + d12 * e22, d12 * e11 + d11 * e22, d33 * e12
                s11, s22, s12 = (
                    r11 + d11 * h0 + d12 * h3,
                    r22 + d12 * h0 + d11 * h3,
                    r12 + d33 * (h1 + h2),
                )
                p0, p1 = h0 * s11 + h1 * s12 + r11, h0 * s12 + h1 * s22 + r12
                p2, p3 = h2 * s11 + h3 * s12 + r12, h2 * s12 + h3 * s22 + r22
                for a in range(free):
                    n0, n1 = (
                        entry(table, at + 3 + 2 * a, e, states),
                        entry(table, at + 4 + 2 * a, e, states),
                    )
                    put(g, 2 * a, get(g, 2 * a, width) + n0 * p0 + n1 * p1)
                    put(g, 2 * a + 1, get(g, 2 * a + 1, width) + n0 * p2 + n1 * p3)
            for a in range(2 * free):
                put(g, 2 * free + a % 2, get(g, 2 * free + a % 2, width) - get(g, a, width))
            for a in range(2 * shapes):
                if states == 1:
                    for lane in range(width):
                        dof = dofs[e + lane, a]
                        if dof >= 0:
                            f[dof, 0] += g[a, lane]
                else:
                    dof = dofs[e, a]
                    if dof >= 0:
                        put(f, dof, get(f, dof, width) + get(g, a, width))

    return force


def _tangent(shapes: int, points: int, states: int):
    stride, width, together, free = (
        3 + 2 * (shapes - 1),
        (WIDTH if states == 1 else states),
        (WIDTH if states == 1 else 1),
        shapes - 1,
    )
    entries, of_free = shapes * (2 * shapes + 1), free * (2 * free + 1)

    @tangent_kernel
    def tangent(q, v, dofs, table, slots, scale_q, scale_v, values):
        u, ke = room(2 * shapes, width), room(entries, width)
        for e in range(0, dofs.shape[0], together):
            gather(q, dofs, e, u, states, width)
            for slot in range(of_free):
                put(ke, slot, 0.0 - entry(table, points * stride + slot, e, states))
            for slot in range(of_free, entries):
                put(ke, slot, fill(0.0, width))
            for k in range(points):
                at = k * stride
                d11, d12, d33 = (
                    entry(table, at, e, states),
                    entry(table, at + 1, e, states),
                    entry(table, at + 2, e, states),
                )
                h0, h1, h2, h3 = gradient(u, table, at + 3, e, free, states, width)
                e11, e22 = h0 + 0.5 * (h0 * h0 + h2 * h2), h3 + 0.5 * (h1 * h1 + h3 * h3)
                s11, s22, s12 = (
                    d11 * e11 + d12 * e22,
                    d12 * e11 + d11 * e22,
                    d33 * (h1 + h2 + h0 * h1 + h2 * h3),
                )
                f0, f3 = 1.0 + h0, 1.0 + h3
                # A_iJ,jL by rows of i and columns of j; what is missing follows by symmetry.
                xx00, xx01, xx11 = (
                    d11 * (f0 * f0) + d33 * (h1 * h1) + s11,
                    (d12 + d33) * (f0 * h1) + s12,
                    d11 * (h1 * h1) + d33 * (f0 * f0) + s22,
                )
                yy00, yy01, yy11 = (
                    d11 * (h2 * h2) + d33 * (f3 * f3) + s11,
                    (d12 + d33) * (h2 * f3) + s12,
                    d11 * (f3 * f3) + d33 * (h2 * h2) + s22,
                )
                f02, f13, f03, f12 = f0 * h2, h1 * f3, f0 * f3, h1 * h2
                xy00, xy01, xy10, xy11 = (
                    d11 * f02 + d33 * f13,
                    d12 * f03 + d33 * f12,
                    d12 * f12 + d33 * f03,
                    d11 * f13 + d33 * f02,
                )
                for a in range(free):
                    n0, n1 = (
                        entry(table, at + 3 + 2 * a, e, states),
                        entry(table, at + 4 + 2 * a, e, states),
                    )
                    txx0, txx1, txy0, txy1 = (
                        n0 * xx00 + n1 * xx01,
                        n0 * xx01 + n1 * xx11,
                        n0 * xy00 + n1 * xy10,
                        n0 * xy01 + n1 * xy11,
                    )
                    tyx0, tyx1, tyy0, tyy1 = (
                        n0 * xy00 + n1 * xy01,
                        n0 * xy10 + n1 * xy11,
                        n0 * yy00 + n1 * yy01,
                        n0 * yy01 + n1 * yy11,
                    )
                    x_row, y_row = a * (2 * a + 1), (a + 1) * (2 * a + 1)
                    for b in range(a + 1):
                        m0, m1 = (
                            entry(table, at + 3 + 2 * b, e, states),
                            entry(table, at + 4 + 2 * b, e, states),
                        )
                        put(
                            ke,
                            x_row + 2 * b,
                            get(ke, x_row + 2 * b, width) + m0 * txx0 + m1 * txx1,
                        )
                        put(
                            ke,
                            y_row + 2 * b,
                            get(ke, y_row + 2 * b, width) + m0 * tyx0 + m1 * tyx1,
                        )
                        put(
                            ke,
                            y_row + 2 * b + 1,
                            get(ke, y_row + 2 * b + 1, width) + m0 * tyy0 + m1 * tyy1,
                        )
                        if b < a:
                            put(
                                ke,
                                x_row + 2 * b + 1,
                                get(ke, x_row + 2 * b + 1, width) + m0 * txy0 + m1 * txy1,
                            )
            for row in range(2 * free):
                for column in range(2 * free):
                    from_row = of_free + column if row % 2 == 0 else of_free + 2 * free + 1 + column
                    high, low = max(row, column), min(row, column)
                    put(
                        ke,
                        from_row,
                        get(ke, from_row, width) - get(ke, high * (high + 1) // 2 + low, width),
                    )
            for i in range(2):
                first = of_free + i * (2 * free + 1)
                for column in range(2 * free):
                    if column % 2 <= i:
                        corner = first + 2 * free + column % 2
                        put(ke, corner, get(ke, corner, width) - get(ke, first + column, width))
            if states == 1:
                for lane in range(width):
                    for number in range(entries):
                        slot = slots[e + lane, number]
                        if slot >= 0:
                            values[slot, 0] += scale_q[0] * ke[number, lane]
            else:
                scale = get(scale_q, 0, width)
                for number in range(entries):
                    slot = slots[e, number]
                    if slot >= 0:
                        put(
                            values,
                            slot,
                            get(values, slot, width) + scale * get(ke, number, width),
                        )

    return tangent
