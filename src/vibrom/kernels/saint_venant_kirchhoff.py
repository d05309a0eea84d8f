"""The St. Venant-Kirchhoff material at a point of an element, in lanes; see
`effects/geometric_nonlinearity.py`. One text for bodies of two and of three dimensions.

Gradients H_iJ, stresses P_iJ and the like are tuples by rows; strains e_11, e_22, (e_33, 2 e_23, 2
e_13,) 2 e_12 and their stresses are in the order of PAIRS. A point's rows of the table are D_11,
D_12 and the shear modulus times thickness and weight, then dN_a/dX_J of all nodes but the last,
relative to which displacements are.
"""

import numpy as np

from vibrom.kernels.lanes import fill, inlined
from vibrom.kernels.unrolled import sum_of, unrolled

# Dimension -> the two directions of each component of a strain.
PAIRS = {2: ((0, 0), (1, 1), (0, 1)), 3: ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))}
SIDES = {4: 2, 9: 3}  # components of H -> dimension


@unrolled
def undeformed(zero, dim):
    """H at rest."""
    return (zero,) * dim**2


@unrolled
def unstrained(zero, dim):
    """Strains at rest."""
    return (zero,) * len(PAIRS[dim])


@unrolled
def moduli(table, point, states):
    """D_11, D_12 and the shear modulus, times thickness and weight of the point."""
    at, e = point
    return tuple(table.entry(at + k, e, states) for k in range(3))


@unrolled
def slope(table, point, a, dim, states):
    """dN_a/dX_J."""
    at, e = point
    return tuple(table.entry(at + 3 + a * dim + j, e, states) for j in range(dim))


@unrolled
def add_node(h, u, n, a, width):
    """H with what node a adds."""
    dim = len(n)
    x = [u.get(a * dim + i, width) for i in range(dim)]
    return tuple(h[dim * i + j] + n[j] * x[i] for i in range(dim) for j in range(dim))


@inlined
def gradient(u, table, point, free, dim, states, width):
    """H at a point: the row of the table at which it begins, and the element's column."""
    h = undeformed(fill(0.0, width), dim)
    for a in range(free):
        h = add_node(h, u, slope(table, point, a, dim, states), a, width)
    return h


@unrolled
def quadratic_strains(h):
    """Those of H'H/2."""
    dim = SIDES[len(h)]
    products = {
        (i, j): sum_of(h[dim * k + i] * h[dim * k + j] for k in range(dim)) for i, j in PAIRS[dim]
    }
    return tuple(0.5 * products[i, j] if i == j else products[i, j] for i, j in PAIRS[dim])


@unrolled
def strains(h):
    """Those of (H + H' + H'H)/2."""
    dim = SIDES[len(h)]
    found = []
    for i, j in PAIRS[dim]:
        squares = [h[dim * k + i] * h[dim * k + j] for k in range(dim)]
        linear = [h[dim * i + j], h[dim * j + i]]
        found.append(h[dim * i + i] + 0.5 * sum_of(squares) if i == j else sum_of(linear + squares))
    return tuple(found)


@unrolled
def stresses(d, e):
    """D : e."""
    dim = 2 if len(e) == 3 else 3
    direct = [sum_of(d[i != k] * e[k] for k in range(dim)) for i in range(dim)]
    return (*direct, *(d[2] * e[k] for k in range(dim, len(e))))


@unrolled
def added_stress(d, h, more):
    """F S - D : eps; `more` are strains beside those of H."""
    strain = tuple(x + y for x, y in zip(quadratic_strains.plain(h), more))
    return first_stress(d, h, h, stresses.plain(d, strain))


def first_stress(d, h, k, r):
    """F S - D : sym K with the stress S = D : sym K + r."""
    dim = SIDES[len(h)]
    s = []
    for number, (i, j) in enumerate(PAIRS[dim]):
        if i == j:
            s.append(sum_of([r[number], *(d[i != m] * k[dim * m + m] for m in range(dim))]))
        else:
            s.append(r[number] + d[2] * (k[dim * i + j] + k[dim * j + i]))
    r, s = square(r), square(s)
    return tuple(
        sum_of([*(h[dim * i + k] * s[k][j] for k in range(dim)), r[i][j]])
        for i in range(dim)
        for j in range(dim)
    )


def square(x):
    """A symmetric tensor as rows."""
    dim = 2 if len(x) == 3 else 3
    place = {pair: number for number, pair in enumerate(PAIRS[dim])}
    return [[x[place[min(i, j), max(i, j)]] for j in range(dim)] for i in range(dim)]


@unrolled
def add_share(g, p, n, a, width):
    """P_iJ dN_a/dX_J to g."""
    dim = len(n)
    for i in range(dim):
        parts = [n[j] * p[dim * i + j] for j in range(dim)]
        g.put(a * dim + i, sum_of([g.get(a * dim + i, width), *parts]))


@inlined
def add_force(u, more, g, table, point, dim, states, width):
    """Adds a point's share of (F S - D : eps)_iJ dN_a/dX_J to g, for all nodes but the last."""
    free = u.shape[0] // dim - 1
    h = gradient(u, table, point, free, dim, states, width)
    p = added_stress(moduli(table, point, states), h, more)
    for a in range(free):
        add_share(g, p, slope(table, point, a, dim, states), a, width)


def moduli_block(d, row, column):
    """F_iI G_jK D_IJ,KL by rows J of a row i of F and a row j of G."""
    dim = len(row)
    made = []
    for j in range(dim):
        for l in range(dim):
            if j == l:
                shear = [d[2] * (row[i] * column[i]) for i in range(dim) if i != j]
                made.append(sum_of([d[0] * (row[j] * column[j]), *shear]))
            elif row is column:
                made.append((d[1] + d[2]) * (row[j] * row[l]))
            else:
                made.append(d[1] * (row[j] * column[l]) + d[2] * (row[l] * column[j]))
    return made


def deformation(h):
    """The rows of F."""
    dim = SIDES[len(h)]
    rows = [list(h[dim * i : dim * (i + 1)]) for i in range(dim)]
    for i in range(dim):
        rows[i][i] = 1.0 + rows[i][i]
    return rows


@unrolled
def elasticity(d, h):
    """A_iJ,jL of a point: block by block of i and j, by rows J."""
    dim = SIDES[len(h)]
    f, s = deformation(h), square(stresses.plain(d, strains.plain(h)))
    stress = [s[j][l] for j in range(dim) for l in range(dim)]
    blocks = {(i, j): moduli_block(d, f[i], f[j]) for i in range(dim) for j in range(i, dim)}
    for i in range(dim):
        blocks[i, i] = [x + y for x, y in zip(blocks[i, i], stress)]
        for j in range(i):  # A_jL,iJ
            blocks[i, j] = [blocks[j, i][dim * l + k] for k in range(dim) for l in range(dim)]
    return tuple(x for i in range(dim) for j in range(dim) for x in blocks[i, j])


@unrolled
def mean_elasticity(d, h, k):
    """The same with F of the middle H for i and of the end H + K for j, and the stress of the mean
    strain.
    """
    dim = SIDES[len(h)]
    parts = zip(PAIRS[dim], quadratic_strains.plain(h), quadratic_strains.plain(k))
    mean = []
    for (i, j), one, more in parts:
        linear = h[dim * i + i] if i == j else h[dim * i + j] + h[dim * j + i]
        mean.append(linear + one + more)
    s = square(stresses.plain(d, mean))
    f, end = deformation(h), deformation([x + y for x, y in zip(h, k)])
    made = []
    for i in range(dim):
        for j in range(dim):
            block = moduli_block(d, f[i], end[j])
            stress = [s[a][b] for a in range(dim) for b in range(dim)]
            made += [x + y for x, y in zip(block, stress)] if i == j else block
    return tuple(made)


@unrolled
def contracted(n, moduli):
    """n_J A_iJ,jL: block by block of i and j."""
    dim = len(n)
    return tuple(
        sum_of(n[j] * moduli[dim * (dim * block + j) + l] for j in range(dim))
        for block in range(dim * dim)
        for l in range(dim)
    )


@unrolled
def add_entries(ke, first, step, t, m, above, width):
    """t_ij,L m_L to the rows i of ke, a lower triangle in which they begin at first, first + step,
    first + 2 step + 1: to columns up to i or, of `above`, beyond it.
    """
    dim = len(m)
    for i in range(dim):
        for j in range(i + 1, dim) if above else range(i + 1):
            place = first + step * i + (i * (i - 1) // 2 + j)
            parts = [m[l] * t[dim * (dim * i + j) + l] for l in range(dim)]
            ke.put(place, sum_of([ke.get(place, width), *parts]))


@inlined
def add_tangent(u, ke, table, point, free, dim, states, width):
    """Adds a point's share of dN_a/dX_J A_iJ,jL dN_b/dX_L to ke, for all nodes but the last: lower
    triangle, row by row.
    """
    h = gradient(u, table, point, free, dim, states, width)
    a_ij = elasticity(moduli(table, point, states), h)
    for a in range(free):
        t, row = contracted(slope(table, point, a, dim, states), a_ij), dim * a
        for b in range(a + 1):
            m, place = slope(table, point, b, dim, states), row * (row + 1) // 2 + dim * b
            add_entries(ke, place, row + 1, t, m, 0, width)
            if b < a:
                add_entries(ke, place, row + 1, t, m, 1, width)


@unrolled
def add_whole(ke, first, size, t, m, width):
    """t_ij,L m_L to the rows i of ke, `size` long."""
    dim = len(m)
    for i in range(dim):
        for j in range(dim):
            place = first + (size * i + j)
            parts = [m[l] * t[dim * (dim * i + j) + l] for l in range(dim)]
            ke.put(place, sum_of([ke.get(place, width), *parts]))


@inlined
def add_blocks(a_ij, ke, table, point, free, dim, states, width):
    """Adds dN_a/dX_J A_iJ,jL dN_b/dX_L to ke, for all nodes but the last: the whole matrix, row by
    row.
    """
    size = dim * (free + 1)
    for a in range(free):
        t = contracted(slope(table, point, a, dim, states), a_ij)
        for b in range(free):
            m, place = slope(table, point, b, dim, states), dim * (a * size + b)
            add_whole(ke, place, size, t, m, width)


@inlined
def add_mean_tangent(u, half, ke, table, point, dim, states, width):
    """Adds a point's share of the mean force's derivative to ke, for all nodes but the last: the
    whole matrix, row by row.
    """
    free = u.shape[0] // dim - 1
    h = gradient(u, table, point, free, dim, states, width)
    k = gradient(half, table, point, free, dim, states, width)
    a_ij = mean_elasticity(moduli(table, point, states), h, k)
    add_blocks(a_ij, ke, table, point, free, dim, states, width)


def table_of(elastic, weights, gradients):
    """What kernels know of a body's elements (elements, points * rows of a point), of weights
    (elements, points) and gradients (shapes, dim, elements, points) of the shape functions.

    Rigid motion changes nothing: the shape functions add up to one, and the last one's part is
    minus the sum of the others'.
    """
    shapes, dim, elements, points = gradients.shape
    moduli = weights * np.array([elastic[0, 0], elastic[0, 1], elastic[-1, -1]])[:, None, None]
    kept = gradients[:-1].reshape(dim * (shapes - 1), elements, points)
    return np.concatenate([moduli, kept]).transpose(1, 2, 0).reshape(elements, -1)
