"""The St. Venant-Kirchhoff material at a point of a plane element, in lanes; see
`effects/geometric_nonlinearity.py`.

A point's rows of the table are D_11, D_12 and D_33 times thickness and weight, then dN_a/dX_1 and
dN_a/dX_2 of all nodes but the last, relative to which displacements are.
"""

from vibrom.kernels.lanes import entry, fill, get, inlined, put


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
def quadratic_strains(h):
    """e_11, e_22 and 2 e_12 of H'H/2."""
    e11, e22 = 0.5 * (h[0] * h[0] + h[2] * h[2]), 0.5 * (h[1] * h[1] + h[3] * h[3])
    return e11, e22, h[0] * h[1] + h[2] * h[3]


@inlined
def add_force(u, more, g, table, at, e, states, width):
    """Adds a point's share of (F S - D : eps)_iJ dN_a/dX_J to g, for all nodes but the last; `more`
    are strains beside those of u.
    """
    free = u.shape[0] // 2 - 1
    d11, d12, d33 = moduli(table, at, e, states)
    h0, h1, h2, h3 = h = gradient(u, table, at, e, free, states, width)
    # Quadratic strains e, their stresses r, and all stresses s.
    one = quadratic_strains(h)
    e11, e22, e12 = one[0] + more[0], one[1] + more[1], one[2] + more[2]
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
def elasticity(table, at, e, h, states):
    """A_iJ,jL of a point by rows of i and columns of j: xx (symmetric), yy (symmetric), xy."""
    d11, d12, d33 = moduli(table, at, e, states)
    h0, h1, h2, h3 = h
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
    h = gradient(u, table, at, e, free, states, width)
    xx, yy, xy = elasticity(table, at, e, h, states)
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
def block(d, row, column, s):
    """A_iJ,jL of a row i of F and a row j of F at the end of the step, and S of the mean strain
    where i = j, else zeros.
    """
    same11, same22 = row[0] * column[0], row[1] * column[1]
    one00, one11 = d[0] * same11 + d[2] * same22, d[0] * same22 + d[2] * same11
    mixed01, mixed10 = row[0] * column[1], row[1] * column[0]
    one01, one10 = d[1] * mixed01 + d[2] * mixed10, d[1] * mixed10 + d[2] * mixed01
    return one00 + s[0], one01 + s[2], one10 + s[2], one11 + s[1]


@inlined
def add_mean_tangent(u, half, ke, table, at, e, states, width):
    """Adds a point's share of the mean force's derivative to ke, for all nodes but the last: the
    whole matrix, row by row.
    """
    free = u.shape[0] // 2 - 1
    h = gradient(u, table, at, e, free, states, width)
    k = gradient(half, table, at, e, free, states, width)
    d = moduli(table, at, e, states)
    one, more = quadratic_strains(h), quadratic_strains(k)
    e11, e22, e12 = h[0] + one[0] + more[0], h[3] + one[1] + more[1], h[1] + h[2] + one[2] + more[2]
    s = d[0] * e11 + d[1] * e22, d[1] * e11 + d[0] * e22, d[2] * e12
    none = fill(0.0, width)
    x, y = (1.0 + h[0], h[1]), (h[2], 1.0 + h[3])
    x_end, y_end = (1.0 + h[0] + k[0], h[1] + k[1]), (h[2] + k[2], 1.0 + h[3] + k[3])
    xx, yy = block(d, x, x_end, s), block(d, y, y_end, s)
    xy, yx = block(d, x, y_end, (none, none, none)), block(d, y, x_end, (none, none, none))
    size = 2 * (free + 1)
    for a in range(free):
        n0 = entry(table, at + 3 + 2 * a, e, states)
        n1 = entry(table, at + 4 + 2 * a, e, states)
        for b in range(free):
            m0 = entry(table, at + 3 + 2 * b, e, states)
            m1 = entry(table, at + 4 + 2 * b, e, states)
            place = 2 * a * size + 2 * b
            p00, p01, p10, p11 = n0 * m0, n0 * m1, n1 * m0, n1 * m1
            added = p00 * xx[0] + p01 * xx[1] + p10 * xx[2] + p11 * xx[3]
            put(ke, place, get(ke, place, width) + added)
            added = p00 * xy[0] + p01 * xy[1] + p10 * xy[2] + p11 * xy[3]
            put(ke, place + 1, get(ke, place + 1, width) + added)
            added = p00 * yx[0] + p01 * yx[1] + p10 * yx[2] + p11 * yx[3]
            put(ke, place + size, get(ke, place + size, width) + added)
            added = p00 * yy[0] + p01 * yy[1] + p10 * yy[2] + p11 * yy[3]
            put(ke, place + size + 1, get(ke, place + size + 1, width) + added)
