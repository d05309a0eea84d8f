"""Between a body and its elements, in lanes: nodes with `dim` displacements each.

An element's displacements are gathered relative to its last node: as shape functions add up to
one, rigid translations then make no force to the last bit, and the last node's part is minus the
sum of the others'. Lanes are states. For one state alone they are WIDTH elements, e, e + 1, ...,
whose displacements are gathered, and whose forces are added, one element after the other.
"""

from vibrom.kernels.lanes import fill, get, inlined, put


@inlined
def gather(q, first, dofs, e, u, dim, states, width):
    """Displacements u (dim shapes, width) of an element's nodes relative to its last node, which is
    itself left as it is; q begins at row `first`.
    """
    last = u.shape[0] - dim
    for a in range(u.shape[0]):
        if states == 1:
            for lane in range(width):
                dof = dofs[e + lane, a]
                u[a, lane] = q[first + dof, 0] if dof >= 0 else 0.0
        else:
            dof = dofs[e, a]
            put(u, a, get(q, first + dof, width) if dof >= 0 else fill(0.0, width))
    for a in range(last):
        put(u, a, get(u, a, width) - get(u, last + a % dim, width))


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


@inlined
def complete(ke, free, dim, width):
    """The rows of the last node: what they lack for rigid translations to make no force."""
    first = dim * free  # the last node's first row
    for row in range(first):
        for column in range(first):
            last = first + row % dim
            at, high, low = last * (last + 1) // 2 + column, max(row, column), min(row, column)
            put(ke, at, get(ke, at, width) - get(ke, high * (high + 1) // 2 + low, width))
    for i in range(dim):
        row = (first + i) * (first + i + 1) // 2
        for column in range(first):
            if column % dim <= i:
                at = row + first + column % dim
                put(ke, at, get(ke, at, width) - get(ke, row + column, width))


@inlined
def complete_whole(ke, free, dim, width):
    """The same of a matrix that is not symmetric: whole, row by row."""
    size, last = dim * (free + 1), dim * free
    for row in range(last):
        for i in range(dim):
            total = fill(0.0, width)
            for b in range(free):
                total -= get(ke, row * size + dim * b + i, width)
            put(ke, row * size + last + i, total)
    for column in range(size):
        for i in range(dim):
            total = fill(0.0, width)
            for a in range(free):
                total -= get(ke, (dim * a + i) * size + column, width)
            put(ke, (last + i) * size + column, total)


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
