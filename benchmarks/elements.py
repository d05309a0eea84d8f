"""Speed of the element kernels by arithmetic: bodies in space beside the bilinear rectangle.

Additions and multiplications of the material's force and tangent in all elements of a body, counted
by running the text of the kernels with numbers that count, over the time that they take; what
gathers and scatters is not counted. One state alone, and sixteen side by side. The rival is the
bilinear rectangle: less than three times as slow an operation was asked of bodies in space.
"""

from collections.abc import Iterator

import numpy as np

from benchmarks.table import Row, paired
from vibrom import effects
from vibrom.bodies import space
from vibrom.kernels import saint_venant_kirchhoff as material

RECTANGLE, CALLS = "bilinear rectangle", 20
SIZE = {"length": 1.0, "height": 0.1, "width": 0.1, "clamped": ["left"], "probes": {}}
BLOCK = {"shape": "block", **SIZE}
BODIES = {  # about 500 elements
    RECTANGLE: {**SIZE, "cells": [128, 4], "element": "bilinear"},
    "quadratic rectangle": {**SIZE, "cells": [128, 4], "element": "quadratic"},
    "trilinear block": {**BLOCK, "cells": [32, 4, 4], "element": "trilinear"},
    "serendipity block": {**BLOCK, "cells": [32, 4, 4], "element": "serendipity"},
}
EFFECTS = {
    "inertia": {"density": 440.0},
    "elasticity": {"young_modulus": 104.0e9, "poisson_ratio": 0.3},
    "geometric_nonlinearity": {},
}


class Counting:
    """A number that counts what is done with it."""

    done = 0

    def _one_more(self, other):
        Counting.done += 1
        return self

    __add__ = __radd__ = __sub__ = __rsub__ = __mul__ = __rmul__ = _one_more


def counted(function, *arguments) -> int:
    before = Counting.done
    function(*arguments)
    return Counting.done - before


def operations(dim: int, nodes: int, points: int) -> dict[str, int]:
    """Of an element's force and of its tangent."""
    free, number = nodes - 1, Counting()
    d, h, n = ((number,) * size for size in (3, dim * dim, dim))
    strains = (number,) * len(material.PAIRS[dim])
    gradient = free * 2 * dim * dim
    force = 2 * gradient + counted(material.added_stress.plain, d, h, strains)
    moduli = (number,) * dim**4
    tangent = gradient + counted(material.elasticity.plain, d, h)
    tangent += free * counted(material.contracted.plain, n, moduli)
    # Of each pair of nodes a block, of a node with itself its lower half.
    entries = free * (free - 1) // 2 * dim * dim + free * dim * (dim + 1) // 2
    tangent += entries * 2 * dim
    return {"force": points * force, "tangent": points * tangent}


def calls(name: str, states: int) -> dict[str, tuple[float, object]]:
    """Of each kernel: billions of operations in a call, and the call."""
    body = space.build(BODIES[name])
    dim, shapes = body.dimension, len(body.scalar.basis)
    elements, points = body.scalar.dx.shape
    (force,) = effects.assemble(body, EFFECTS).forces
    add, add_tangent = force.kernels(states)
    q = np.random.default_rng(0).standard_normal((body.size, states)) * 1e-3
    v, f, scale = np.zeros_like(q), np.zeros_like(q), np.ones(states)
    size = force.dofs.shape[1]
    slots = np.arange(len(force.dofs) * size * (size + 1) // 2).reshape(len(force.dofs), -1)
    values = np.zeros((slots.size, states))
    total = {
        key: 1e-9 * elements * states * one for key, one in operations(dim, shapes, points).items()
    }

    def forces():
        for _ in range(CALLS):
            add(q, v, force.dofs, force.table, f)

    def tangents():
        for _ in range(CALLS):
            add_tangent(q, v, force.dofs, force.table, slots, scale, scale, values)

    return {"force": (total["force"], forces), "tangent": (total["tangent"], tangents)}


def measure(note) -> Iterator[Row]:
    note(f"{CALLS} calls of each kernel, which take turns")
    for states, batch in ((1, "one state"), (16, "sixteen")):
        made = {name: calls(name, states) for name in BODIES}
        for kind in ("force", "tangent"):
            seconds = paired({name: made[name][kind][1] for name in BODIES}, repeats=9)
            rate = {name: CALLS * made[name][kind][0] / seconds[name] for name in BODIES}
            for name in BODIES:
                if name != RECTANGLE:
                    yield Row(
                        "elements",
                        f"{kind} of a {name}, {batch}",
                        rate[name],
                        "Gflop/s",
                        RECTANGLE,
                        rate[RECTANGLE],
                        better="higher",
                    )
