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
from scipy.sparse import csr_matrix

from vibrom.bodies.space import Space
from vibrom.kernels.lanes import WIDTH, entry, fill, get, inlined, put, stack
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
    return _force(shapes, points, states), _tangent(shapes, points, states)


# Lanes are states. For one state alone they are WIDTH elements, e, e + 1, ..., whose displacements
# are gathered, and whose forces are added, one element after the other.


@inlined
def gather(q, dofs, e, u, states, width):
    """Displacements u (2 shapes, width) of an element's nodes relative to its last node, which is
    itself left as it is.
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


@inlined
def gradient(u, table, at, e, free, states, width):
    """H_11, H_12, H_21, H_22 at the point whose rows of the table begin at `at`."""
    h0 = h1 = h2 = h3 = fill(0.0, width)
    for a in range(free):
        n0 = entry(table, at + 3 + 2 * a, e, states)
        n1 = entry(table, at + 4 + 2 * a, e, states)
        ux, uy = get(u, 2 * a, width), get(u, 2 * a + 1, width)
        h0 += n0 * ux
        h1 += n1 * ux
        h2 += n0 * uy
        h3 += n1 * uy
    return h0, h1, h2, h3


@inlined
def moduli(table, at, e, states):
    """D_11, D_12, D_33 times thickness and weight of the point."""
    d11, d12 = entry(table, at, e, states), entry(table, at + 1, e, states)
    return d11, d12, entry(table, at + 2, e, states)


@inlined
def add_force(u, g, table, at, e, free, states, width):
    """Adds a point's share of (F S - D : eps)_iJ dN_a/dX_J to g, for all nodes but the last."""
    d11, d12, d33 = moduli(table, at, e, states)
    h0, h1, h2, h3 = gradient(u, table, at, e, free, states, width)
    # Quadratic strains e, their stresses r, and all stresses s.
    e11, e22 = 0.5 * (h0 * h0 + h2 * h2), 0.5 * (h1 * h1 + h3 * h3)
    e12 = h0 * h1 + h2 * h3
    r11, r22, r12 = d11 * e11 + d12 * e22, d12 * e11 + d11 * e22, d33 * e12
    s11, s22 = r11 + d11 * h0 + d12 * h3, r22 + d12 * h0 + d11 * h3
    s12 = r12 + d33 * (h1 + h2)
    p0, p1 = h0 * s11 + h1 * s12 + r11, h0 * s12 + h1 * s22 + r12
    p2, p3 = h2 * s11 + h3 * s12 + r12, h2 * s12 + h3 * s22 + r22
    for a in range(free):
        n0 = entry(table, at + 3 + 2 * a, e, states)
        n1 = entry(table, at + 4 + 2 * a, e, states)
        put(g, 2 * a, get(g, 2 * a, width) + n0 * p0 + n1 * p1)
        put(g, 2 * a + 1, get(g, 2 * a + 1, width) + n0 * p2 + n1 * p3)


@inlined
def scatter(g, dofs, e, f, states, width):
    """Adds the forces g of an element, or of WIDTH elements, to f."""
    for a in range(g.shape[0]):
        if states == 1:
            for lane in range(width):
                dof = dofs[e + lane, a]
                if dof >= 0:
                    f[dof, 0] += g[a, lane]
        else:
            dof = dofs[e, a]
            if dof >= 0:
                put(f, dof, get(f, dof, width) + get(g, a, width))


def _force(shapes: int, points: int, states: int):
    width, together = (WIDTH, WIDTH) if states == 1 else (states, 1)
    free, rows, stride = shapes - 1, 2 * shapes, 2 * shapes + 1

    @force_kernel
    def force(q, v, dofs, table, f):
        u, g = stack(rows, width), stack(rows, width)
        for e in range(0, dofs.shape[0], together):
            gather(q, dofs, e, u, states, width)
            for a in range(rows):
                put(g, a, fill(0.0, width))
            for point in range(points):
                add_force(u, g, table, point * stride, e, free, states, width)
            for a in range(2 * free):
                put(g, 2 * free + a % 2, get(g, 2 * free + a % 2, width) - get(g, a, width))
            scatter(g, dofs, e, f, states, width)

    return force


@inlined
def elasticity(table, at, e, h0, h1, h2, h3, states):
    """A_iJ,jL of a point by rows of i and columns of j: xx (symmetric), yy (symmetric), xy."""
    d11, d12, d33 = moduli(table, at, e, states)
    e11, e22 = h0 + 0.5 * (h0 * h0 + h2 * h2), h3 + 0.5 * (h1 * h1 + h3 * h3)
    s11, s22 = d11 * e11 + d12 * e22, d12 * e11 + d11 * e22
    s12 = d33 * (h1 + h2 + h0 * h1 + h2 * h3)
    f0, f3 = 1.0 + h0, 1.0 + h3
    xx00 = d11 * (f0 * f0) + d33 * (h1 * h1) + s11
    xx01 = (d12 + d33) * (f0 * h1) + s12
    xx11 = d11 * (h1 * h1) + d33 * (f0 * f0) + s22
    yy00 = d11 * (h2 * h2) + d33 * (f3 * f3) + s11
    yy01 = (d12 + d33) * (h2 * f3) + s12
    yy11 = d11 * (f3 * f3) + d33 * (h2 * h2) + s22
    f02, f13, f03, f12 = f0 * h2, h1 * f3, f0 * f3, h1 * h2
    xy00, xy01 = d11 * f02 + d33 * f13, d12 * f03 + d33 * f12
    xy10, xy11 = d12 * f12 + d33 * f03, d11 * f13 + d33 * f02
    return (xx00, xx01, xx11), (yy00, yy01, yy11), (xy00, xy01, xy10, xy11)


@inlined
def add_tangent(u, ke, table, at, e, free, states, width):
    """Adds a point's share of dN_a/dX_J A_iJ,jL dN_b/dX_L to ke, for all nodes but the last: lower
    triangle, row by row.
    """
    h0, h1, h2, h3 = gradient(u, table, at, e, free, states, width)
    xx, yy, xy = elasticity(table, at, e, h0, h1, h2, h3, states)
    for a in range(free):
        n0 = entry(table, at + 3 + 2 * a, e, states)
        n1 = entry(table, at + 4 + 2 * a, e, states)
        txx0, txx1 = n0 * xx[0] + n1 * xx[1], n0 * xx[1] + n1 * xx[2]
        txy0, txy1 = n0 * xy[0] + n1 * xy[2], n0 * xy[1] + n1 * xy[3]
        tyx0, tyx1 = n0 * xy[0] + n1 * xy[1], n0 * xy[2] + n1 * xy[3]
        tyy0, tyy1 = n0 * yy[0] + n1 * yy[1], n0 * yy[1] + n1 * yy[2]
        x_row, y_row = a * (2 * a + 1), (a + 1) * (2 * a + 1)
        for b in range(a + 1):
            m0 = entry(table, at + 3 + 2 * b, e, states)
            m1 = entry(table, at + 4 + 2 * b, e, states)
            x, y = x_row + 2 * b, y_row + 2 * b
            put(ke, x, get(ke, x, width) + m0 * txx0 + m1 * txx1)
            put(ke, y, get(ke, y, width) + m0 * tyx0 + m1 * tyx1)
            put(ke, y + 1, get(ke, y + 1, width) + m0 * tyy0 + m1 * tyy1)
            if b < a:
                put(ke, x + 1, get(ke, x + 1, width) + m0 * txy0 + m1 * txy1)


@inlined
def complete(ke, free, width):
    """The rows of the last node: what they lack for rigid translations to make no force."""
    first = free * (2 * free + 1)  # entry of the last node's first row
    for row in range(2 * free):
        for column in range(2 * free):
            at = first + column if row % 2 == 0 else first + 2 * free + 1 + column
            high, low = max(row, column), min(row, column)
            put(ke, at, get(ke, at, width) - get(ke, high * (high + 1) // 2 + low, width))
    for i in range(2):
        row = first + i * (2 * free + 1)
        for column in range(2 * free):
            if column % 2 <= i:
                at = row + 2 * free + column % 2
                put(ke, at, get(ke, at, width) - get(ke, row + column, width))


@inlined
def scatter_tangent(ke, slots, e, scale_q, values, states, width):
    """Adds scale_q times the matrix of an element, or of WIDTH elements, to values."""
    for number in range(ke.shape[0]):
        if states == 1:
            for lane in range(width):
                slot = slots[e + lane, number]
                if slot >= 0:
                    values[slot, 0] += scale_q[0] * ke[number, lane]
        else:
            slot = slots[e, number]
            if slot >= 0:
                change = get(scale_q, 0, width) * get(ke, number, width)
                put(values, slot, get(values, slot, width) + change)


def _tangent(shapes: int, points: int, states: int):
    width, together = (WIDTH, WIDTH) if states == 1 else (states, 1)
    free, rows, stride = shapes - 1, 2 * shapes, 2 * shapes + 1
    entries, of_free = shapes * (2 * shapes + 1), free * (2 * free + 1)

    @tangent_kernel
    def tangent(q, v, dofs, table, slots, scale_q, scale_v, values):
        u, ke = stack(rows, width), stack(entries, width)
        for e in range(0, dofs.shape[0], together):
            gather(q, dofs, e, u, states, width)
            for number in range(of_free):  # less the linear part
                put(ke, number, 0.0 - entry(table, points * stride + number, e, states))
            for number in range(of_free, entries):
                put(ke, number, fill(0.0, width))
            for point in range(points):
                add_tangent(u, ke, table, point * stride, e, free, states, width)
            complete(ke, free, width)
            scatter_tangent(ke, slots, e, scale_q, values, states, width)

    return tangent
