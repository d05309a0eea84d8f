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
        table = np.ascontiguousarray(np.concatenate([moduli, geometry.reshape(elements, -1), linear], axis=1))
        return Term(forces=(Force(partial(_kernels, shapes, points), space.element_dofs, table),))


def _linear_stiffness(elastic: np.ndarray, weights: np.ndarray, gradients: np.ndarray) -> np.ndarray:
    """(elements, d(d+1)/2) lower triangles, row by row, of the elements' linear stiffness [N/m]."""
    shapes = len(gradients)
    b = np.zeros((3, 2 * shapes, *weights.shape))
    b[0, 0::2], b[1, 1::2] = gradients[:, 0], gradients[:, 1]
    b[2, 0::2], b[2, 1::2] = gradients[:, 1], gradients[:, 0]
    full = np.einsum("iaek,ij,jbek,ek->eab", b, elastic, b, weights, optimize=True)
    return full[:, *np.tril_indices(2 * shapes)]


@cache
def _kernels(shapes: int, points: int, width: int):
    return _force(shapes, points, width), _tangent(shapes, points, width)


def _force(shapes: int, points: int, width: int):
    stride = 1 + 2 * shapes

    @force_kernel
    def force(q, v, dofs, table, f):
        u, g = np.empty((2 * shapes, width)), np.empty((2 * shapes, width))
        h, p = np.empty((4, width)), np.empty((4, width))
        for e in range(dofs.shape[0]):
            d11, d12, d33 = table[e, 0], table[e, 1], table[e, 2]
            for a in range(2 * shapes):
                dof = dofs[e, a]
                for w in range(width):
                    u[a, w] = q[dof, w] if dof >= 0 else 0.0
                    g[a, w] = 0.0
            for k in range(points):
                at = 3 + k * stride
                weight = table[e, at]
                for w in range(width):
                    h[0, w] = h[1, w] = h[2, w] = h[3, w] = 0.0
                for a in range(shapes):
                    n0, n1 = table[e, at + 1 + 2 * a], table[e, at + 2 + 2 * a]
                    for w in range(width):
                        h[0, w] += u[2 * a, w] * n0
                        h[1, w] += u[2 * a, w] * n1
                        h[2, w] += u[2 * a + 1, w] * n0
                        h[3, w] += u[2 * a + 1, w] * n1
                for w in range(width):
                    h0, h1, h2, h3 = h[0, w], h[1, w], h[2, w], h[3, w]
                    e11, e22, e12 = 0.5 * (h0 * h0 + h2 * h2), 0.5 * (h1 * h1 + h3 * h3), h0 * h1 + h2 * h3
                    r11, r22, r12 = d11 * e11 + d12 * e22, d12 * e11 + d11 * e22, d33 * e12
                    s11, s22, s12 = r11 + d11 * h0 + d12 * h3, r22 + d12 * h0 + d11 * h3, r12 + d33 * (h1 + h2)
                    p[0, w] = weight * (h0 * s11 + h1 * s12 + r11)
                    p[1, w] = weight * (h0 * s12 + h1 * s22 + r12)
                    p[2, w] = weight * (h2 * s11 + h3 * s12 + r12)
                    p[3, w] = weight * (h2 * s12 + h3 * s22 + r22)
                for a in range(shapes):
                    n0, n1 = table[e, at + 1 + 2 * a], table[e, at + 2 + 2 * a]
                    for w in range(width):
                        g[2 * a, w] += p[0, w] * n0 + p[1, w] * n1
                        g[2 * a + 1, w] += p[2, w] * n0 + p[3, w] * n1
            for a in range(2 * shapes):
                dof = dofs[e, a]
                if dof >= 0:
                    for w in range(width):
                        f[dof, w] += g[a, w]

    return force


def _tangent(shapes: int, points: int, width: int):
    stride = 1 + 2 * shapes
    entries = shapes * (2 * shapes + 1)

    @tangent_kernel
    def tangent(q, v, dofs, table, slots, scale_q, scale_v, values):
        u, ke = np.empty((2 * shapes, width)), np.empty((entries, width))
        b, db = np.empty((2 * shapes, 3, width)), np.empty((3, width))
        h, s = np.empty((4, width)), np.empty((3, width))
        sn = np.empty((2, width))
        for e in range(dofs.shape[0]):
            d11, d12, d33 = table[e, 0], table[e, 1], table[e, 2]
            for a in range(2 * shapes):
                dof = dofs[e, a]
                for w in range(width):
                    u[a, w] = q[dof, w] if dof >= 0 else 0.0
            for entry in range(entries):
                linear = table[e, 3 + points * stride + entry]
                for w in range(width):
                    ke[entry, w] = -linear
            for k in range(points):
                at = 3 + k * stride
                weight = table[e, at]
                for w in range(width):
                    h[0, w] = h[1, w] = h[2, w] = h[3, w] = 0.0
                for a in range(shapes):
                    n0, n1 = table[e, at + 1 + 2 * a], table[e, at + 2 + 2 * a]
                    for w in range(width):
                        h[0, w] += u[2 * a, w] * n0
                        h[1, w] += u[2 * a, w] * n1
                        h[2, w] += u[2 * a + 1, w] * n0
                        h[3, w] += u[2 * a + 1, w] * n1
                for w in range(width):
                    h0, h1, h2, h3 = h[0, w], h[1, w], h[2, w], h[3, w]
                    e11 = h0 + 0.5 * (h0 * h0 + h2 * h2)
                    e22 = h3 + 0.5 * (h1 * h1 + h3 * h3)
                    s[0, w] = weight * (d11 * e11 + d12 * e22)
                    s[1, w] = weight * (d12 * e11 + d11 * e22)
                    s[2, w] = weight * d33 * (h1 + h2 + h0 * h1 + h2 * h3)
                    h[0, w] = 1.0 + h0
                    h[3, w] = 1.0 + h3
                for a in range(shapes):
                    n0, n1 = table[e, at + 1 + 2 * a], table[e, at + 2 + 2 * a]
                    for i in range(2):
                        for w in range(width):
                            f0, f1 = h[2 * i, w], h[2 * i + 1, w]
                            b[2 * a + i, 0, w] = f0 * n0
                            b[2 * a + i, 1, w] = f1 * n1
                            b[2 * a + i, 2, w] = f0 * n1 + f1 * n0
                entry = 0
                for a in range(shapes):
                    n0, n1 = table[e, at + 1 + 2 * a], table[e, at + 2 + 2 * a]
                    for w in range(width):
                        sn[0, w] = s[0, w] * n0 + s[2, w] * n1
                        sn[1, w] = s[2, w] * n0 + s[1, w] * n1
                    for i in range(2):
                        row = 2 * a + i
                        for w in range(width):
                            b0, b1, b2 = weight * b[row, 0, w], weight * b[row, 1, w], weight * b[row, 2, w]
                            db[0, w] = d11 * b0 + d12 * b1
                            db[1, w] = d12 * b0 + d11 * b1
                            db[2, w] = d33 * b2
                        for column in range(row + 1):
                            if (row - column) % 2 == 0:
                                m0, m1 = table[e, at + 1 + column - i], table[e, at + 2 + column - i]
                                for w in range(width):
                                    ke[entry, w] += (db[0, w] * b[column, 0, w] + db[1, w] * b[column, 1, w] + db[2, w] * b[column, 2, w]
                                                     + sn[0, w] * m0 + sn[1, w] * m1)
                            else:
                                for w in range(width):
                                    ke[entry, w] += db[0, w] * b[column, 0, w] + db[1, w] * b[column, 1, w] + db[2, w] * b[column, 2, w]
                            entry += 1
            for entry in range(entries):
                slot = slots[e, entry]
                if slot >= 0:
                    for w in range(width):
                        values[slot, w] += scale_q[w] * ke[entry, w]

    return tangent
