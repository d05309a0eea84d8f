"""What the St. Venant-Kirchhoff material adds to linear elasticity (total Lagrangian).

    H = grad u,  F = I + H,  E = (H + H' + H'H)/2,  S = D : E,
    f_ai = b int (F S - D : eps)_iJ dN_a/dX_J dA,
    df_ai/du_bj = b int [B_ai . D B_bj + delta_ij dN_a/dX . S dN_b/dX] dA - K_ai,bj,   B_ai = dE/du_ai in Voigt form.

Source: Belytschko, Liu, Moran, Nonlinear Finite Elements for Continua and Structures, chapter 4. The linear part is taken out inside the integrand, so
that small motions lose no digits. Kernels are compiled for a number of shape functions, quadrature points and states side by side.
"""

from dataclasses import dataclass
from functools import cache, partial

import numpy as np

from vibrom.lanes import WIDTH, entry, fill, load, store
from vibrom.space import Space
from vibrom.term import Force, Term, force_kernel, tangent_kernel


@dataclass(frozen=True)
class GeometricNonlinearity:
    def assemble(self, space: Space, base: Term) -> Term:
        elastic = base.require("elastic", "geometric_nonlinearity", "elasticity")
        weights = space.scalar.dx  # (elements, points) [m^2]
        gradients = np.stack([shape[0].grad for shape in space.scalar.basis])  # (shapes, 2, elements, points) [1/m]
        shapes, _, elements, points = gradients.shape
        geometry = np.concatenate([weights[..., None], gradients.transpose(2, 3, 0, 1).reshape(elements, points, 2 * shapes)], axis=-1)
        moduli = np.tile([elastic[0, 0], elastic[0, 1], elastic[2, 2]], (elements, 1))
        linear = _linear_stiffness(elastic, weights, gradients)
        table = np.concatenate([moduli, geometry.reshape(elements, -1), linear], axis=1)
        # Elements that are not there fill the last lanes: clamped and without weight.
        missing = -elements % WIDTH
        dofs = np.pad(space.element_dofs, ((0, missing), (0, 0)), constant_values=-1)
        return Term(forces=(Force(partial(_kernels, shapes, points), dofs, np.ascontiguousarray(np.pad(table, ((0, missing), (0, 0))).T)),))


def _linear_stiffness(elastic: np.ndarray, weights: np.ndarray, gradients: np.ndarray) -> np.ndarray:
    """(elements, d(d+1)/2) lower triangles, row by row, of the elements' linear stiffness [N/m]."""
    shapes = len(gradients)
    b = np.zeros((3, 2 * shapes, *weights.shape))
    b[0, 0::2], b[1, 1::2] = gradients[:, 0], gradients[:, 1]
    b[2, 0::2], b[2, 1::2] = gradients[:, 1], gradients[:, 0]
    full = np.einsum("iaek,ij,jbek,ek->eab", b, elastic, b, weights, optimize=True)
    return full[:, *np.tril_indices(2 * shapes)]


@cache
def _kernels(shapes: int, points: int, states: int):
    return _force(shapes, points, states), _tangent(shapes, points, states)


def _force(shapes: int, points: int, states: int):
    """Lanes are states; for one state they are elements, and reading and adding go one by one."""
    stride, width, together = 1 + 2 * shapes, (WIDTH if states == 1 else states), (WIDTH if states == 1 else 1)

    @force_kernel
    def force(q, v, dofs, table, f):
        u, g = np.empty((2 * shapes, width)), np.empty((2 * shapes, width))
        for e in range(0, dofs.shape[0], together):
            d11, d12, d33 = entry(table, 0, e, states), entry(table, 1, e, states), entry(table, 2, e, states)
            for a in range(2 * shapes):
                if states == 1:
                    for lane in range(width):
                        dof = dofs[e + lane, a]
                        u[a, lane] = q[dof, 0] if dof >= 0 else 0.0
                else:
                    dof = dofs[e, a]
                    store(u, a, load(q, dof, width) if dof >= 0 else fill(0.0, width))
                store(g, a, fill(0.0, width))
            for k in range(points):
                at = 3 + k * stride
                weight = entry(table, at, e, states)
                h0 = h1 = h2 = h3 = fill(0.0, width)
                for a in range(shapes):
                    n0, n1 = entry(table, at + 1 + 2 * a, e, states), entry(table, at + 2 + 2 * a, e, states)
                    ux, uy = load(u, 2 * a, width), load(u, 2 * a + 1, width)
                    h0 += n0 * ux
                    h1 += n1 * ux
                    h2 += n0 * uy
                    h3 += n1 * uy
                e11, e22, e12 = 0.5 * (h0 * h0 + h2 * h2), 0.5 * (h1 * h1 + h3 * h3), h0 * h1 + h2 * h3
                r11, r22, r12 = d11 * e11 + d12 * e22, d12 * e11 + d11 * e22, d33 * e12
                s11, s22, s12 = r11 + d11 * h0 + d12 * h3, r22 + d12 * h0 + d11 * h3, r12 + d33 * (h1 + h2)
                p0, p1 = weight * (h0 * s11 + h1 * s12 + r11), weight * (h0 * s12 + h1 * s22 + r12)
                p2, p3 = weight * (h2 * s11 + h3 * s12 + r12), weight * (h2 * s12 + h3 * s22 + r22)
                for a in range(shapes):
                    n0, n1 = entry(table, at + 1 + 2 * a, e, states), entry(table, at + 2 + 2 * a, e, states)
                    store(g, 2 * a, load(g, 2 * a, width) + n0 * p0 + n1 * p1)
                    store(g, 2 * a + 1, load(g, 2 * a + 1, width) + n0 * p2 + n1 * p3)
            for a in range(2 * shapes):
                if states == 1:
                    for lane in range(width):
                        dof = dofs[e + lane, a]
                        if dof >= 0:
                            f[dof, 0] += g[a, lane]
                else:
                    dof = dofs[e, a]
                    if dof >= 0:
                        store(f, dof, load(f, dof, width) + load(g, a, width))

    return force


def _tangent(shapes: int, points: int, states: int):
    stride, width, together = 1 + 2 * shapes, (WIDTH if states == 1 else states), (WIDTH if states == 1 else 1)
    entries = shapes * (2 * shapes + 1)

    @tangent_kernel
    def tangent(q, v, dofs, table, slots, scale_q, scale_v, values):
        u, ke, b = np.empty((2 * shapes, width)), np.empty((entries, width)), np.empty((6 * shapes, width))
        for e in range(0, dofs.shape[0], together):
            d11, d12, d33 = entry(table, 0, e, states), entry(table, 1, e, states), entry(table, 2, e, states)
            for a in range(2 * shapes):
                if states == 1:
                    for lane in range(width):
                        dof = dofs[e + lane, a]
                        u[a, lane] = q[dof, 0] if dof >= 0 else 0.0
                else:
                    dof = dofs[e, a]
                    store(u, a, load(q, dof, width) if dof >= 0 else fill(0.0, width))
            for slot in range(entries):
                store(ke, slot, 0.0 - entry(table, 3 + points * stride + slot, e, states))
            for k in range(points):
                at = 3 + k * stride
                weight = entry(table, at, e, states)
                h0 = h1 = h2 = h3 = fill(0.0, width)
                for a in range(shapes):
                    n0, n1 = entry(table, at + 1 + 2 * a, e, states), entry(table, at + 2 + 2 * a, e, states)
                    ux, uy = load(u, 2 * a, width), load(u, 2 * a + 1, width)
                    h0 += n0 * ux
                    h1 += n1 * ux
                    h2 += n0 * uy
                    h3 += n1 * uy
                e11, e22 = h0 + 0.5 * (h0 * h0 + h2 * h2), h3 + 0.5 * (h1 * h1 + h3 * h3)
                s11, s22 = weight * (d11 * e11 + d12 * e22), weight * (d12 * e11 + d11 * e22)
                s12 = weight * d33 * (h1 + h2 + h0 * h1 + h2 * h3)
                h0, h3 = 1.0 + h0, 1.0 + h3
                for a in range(shapes):
                    n0, n1 = entry(table, at + 1 + 2 * a, e, states), entry(table, at + 2 + 2 * a, e, states)
                    store(b, 6 * a, n0 * h0)
                    store(b, 6 * a + 1, n1 * h1)
                    store(b, 6 * a + 2, n1 * h0 + n0 * h1)
                    store(b, 6 * a + 3, n0 * h2)
                    store(b, 6 * a + 4, n1 * h3)
                    store(b, 6 * a + 5, n1 * h2 + n0 * h3)
                for a in range(shapes):
                    n0, n1 = entry(table, at + 1 + 2 * a, e, states), entry(table, at + 2 + 2 * a, e, states)
                    along, across = n0 * s11 + n1 * s12, n0 * s12 + n1 * s22
                    for i in range(2):
                        row = 2 * a + i
                        b0, b1, b2 = load(b, 3 * row, width), load(b, 3 * row + 1, width), load(b, 3 * row + 2, width)
                        t0, t1, t2 = weight * (d11 * b0 + d12 * b1), weight * (d12 * b0 + d11 * b1), weight * d33 * b2
                        first = row * (row + 1) // 2
                        for column in range(row + 1):
                            store(ke, first + column, load(ke, first + column, width) + t0 * load(b, 3 * column, width)
                                  + t1 * load(b, 3 * column + 1, width) + t2 * load(b, 3 * column + 2, width))
                        for other in range(a + 1):
                            m0, m1 = entry(table, at + 1 + 2 * other, e, states), entry(table, at + 2 + 2 * other, e, states)
                            at_ke = first + 2 * other + i
                            store(ke, at_ke, load(ke, at_ke, width) + m0 * along + m1 * across)
            if states == 1:
                for lane in range(width):
                    for number in range(entries):
                        slot = slots[e + lane, number]
                        if slot >= 0:
                            values[slot, 0] += scale_q[0] * ke[number, lane]
            else:
                scale = load(scale_q, 0, width)
                for number in range(entries):
                    slot = slots[e, number]
                    if slot >= 0:
                        store(values, slot, load(values, slot, width) + scale * load(ke, number, width))

    return tangent
