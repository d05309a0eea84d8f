"""Between a body and its elements, in lanes: nodes with two displacements each.

An element's displacements are gathered relative to its last node: as shape functions add up to
one, rigid translations then make no force to the last bit, and the last node's part is minus the
sum of the others'. Lanes are states. For one state alone they are WIDTH elements, e, e + 1, ...,
whose displacements are gathered, and whose forces are added, one element after the other.
"""

from vibrom.kernels.lanes import fill, get, inlined, put


@inlined
def gather(q, first, dofs, e, u, states, width):
    """Displacements u (2 shapes, width) of an element's nodes relative to its last node, which is
    itself left as it is; q begins at row `first`.
    """
    last = u.shape[0] - 2
    for a in range(u.shape[0]):
        if states == 1:
            for lane in range(width):
                dof = dofs[e + lane, a]
                u[a, lane] = q[first + dof, 0] if dof >= 0 else 0.0
        else:
            dof = dofs[e, a]
            put(u, a, get(q, first + dof, width) if dof >= 0 else fill(0.0, width))
    for a in range(last):
        put(u, a, get(u, a, width) - get(u, last + a % 2, width))


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
def complete_whole(ke, free, width):
    """The same of a matrix that is not symmetric: whole, row by row."""
    size = 2 * (free + 1)
    for row in range(2 * free):
        for i in range(2):
            total = fill(0.0, width)
            for b in range(free):
                total -= get(ke, row * size + 2 * b + i, width)
            put(ke, row * size + 2 * free + i, total)
    for column in range(size):
        for i in range(2):
            total = fill(0.0, width)
            for a in range(free):
                total -= get(ke, (2 * a + i) * size + column, width)
            put(ke, (2 * free + i) * size + column, total)


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
