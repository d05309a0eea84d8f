"""A pressure that follows the surface of a body in space; see `effects/follower_load.py`.

    f_ai = int N_a c_iJ m_J,    c = cof(1 + H) - 1 = tr(H) 1 - H' + cof(H),    m = p n dA

A facet's row of the table holds, of each of its points, m, then all N_a, then all dN_a/dX_J.
"""

from vibrom.kernels.compiled import part


@part
def gradient(q, w, dofs, table, e, first, h):
    """H (3, 3) of state w at the point whose gradients begin at `first`."""
    h[:] = 0.0
    for a in range(dofs.shape[1]):
        if dofs[e, a] >= 0:
            for j in range(3):
                h[a % 3, j] += q[dofs[e, a], w] * table[e, first + a // 3 * 3 + j]


@part
def turned(h, table, e, at, i):
    """c_iJ m_J."""
    total = 0.0
    for j in range(3):
        k, l, m, n = (i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3
        cofactor = h[k, m] * h[l, n] - h[k, n] * h[l, m]
        trace = h[0, 0] + h[1, 1] + h[2, 2] if i == j else 0.0
        total += table[e, at + j] * (trace - h[j, i] + cofactor)
    return total


@part
def slope(h, table, e, at, i, k, b):
    """Its derivative by H_kb."""
    normal = table[e, at + i] if k == b else 0.0
    total = normal - (table[e, at + k] if i == b else 0.0)
    if k != i:
        other, forward = 3 - i - k, (k - i) % 3 == 1
        for j in range(3):
            if j != b:
                last, ahead = 3 - j - b, (b - j) % 3 == 1
                sign = 1.0 if forward == ahead else -1.0
                total += sign * table[e, at + j] * h[other, last]
    return total
