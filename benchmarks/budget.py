"""What a force, a factor and a solve cost, against what the machine can do.

Floating-point operations are counted from the algorithms (a multiplication and an addition count
two); bytes are those that a call must read and write at least once. The peak of the machine is
measured: chains of multiply-adds on registers, in the same lanes as the kernels, and copies between
arrays of the size of a factor. What is missing from the peak is latency: an element adds its forces
one after the other to the shared vector, and a column of a narrow band waits for the one before.
"""

from collections.abc import Callable, Iterator

import numpy as np
from numba import types

from benchmarks.cantilever import build, released
from benchmarks.table import Row, paired
from vibrom.kernels import banded
from vibrom.kernels.lanes import fill, get, kernel, put, room

STATES, CALLS = 16, 200
_rows = types.float64[:, ::1]


@kernel(types.void(_rows, types.int64))
def _peak(x, rounds):
    a, b, c, d, e, f, g, h = (
        get(x, 0, 8),
        get(x, 1, 8),
        get(x, 2, 8),
        get(x, 3, 8),
        get(x, 4, 8),
        get(x, 5, 8),
        get(x, 6, 8),
        get(x, 7, 8),
    )
    factor, shift = fill(1.0 - 1e-9, 8), fill(1e-9, 8)
    for _ in range(rounds):
        a, b, c, d = a * factor + shift, b * factor + shift, c * factor + shift, d * factor + shift
        e, f, g, h = e * factor + shift, f * factor + shift, g * factor + shift, h * factor + shift
    put(x, 0, a + b + c + d + e + f + g + h)


def _often(call: Callable, *arguments) -> Callable[[], None]:
    def run() -> None:
        for _ in range(CALLS):
            call(*arguments)

    return run


def measure(note) -> Iterator[Row]:
    model = build()
    force, n = model.term.forces[0], model.space.size
    half = banded.half_bandwidth(model.term.stiffness)
    depth, elements = half + 1, len(force.dofs)
    band_of_mass = banded.to_band(model.term.mass, half)[:, :, None]

    def aligned(values: np.ndarray) -> np.ndarray:
        """(..., STATES) where the time loop would have it: from a cache line on."""
        made = room(values.size // values.shape[-1], STATES).reshape(*values.shape[:-1], STATES)
        made[:] = values
        return made

    q, band, factor, work, copy = (
        aligned(part * np.ones(STATES)) for part in (released()[:, None], *[band_of_mass] * 4)
    )
    internal, tangent = force.kernels(STATES)
    *_, factorise, solve = banded.kernels(STATES)
    slots, scale = banded.band_slots(force.dofs, half), np.full(STATES, 1e-12)
    factorise(factor)
    values, f, x, registers = (
        aligned(np.zeros((n * depth, STATES))),
        aligned(np.zeros_like(q)),
        aligned(q),
        room(8, 8),
    )
    registers[:] = 1.0

    def refactor() -> None:
        work[:] = band
        factorise(work)

    rounds = 100_000
    seconds = paired(
        {
            "force": _often(internal, q, q, force.dofs, force.table, f),
            "tangent": _often(tangent, q, q, force.dofs, force.table, slots, scale, scale, values),
            "factor": _often(refactor),
            "copy": _often(np.copyto, copy, band),
            "solve": _often(solve, factor, x),
            "peak": lambda: _peak(registers, rounds),
        },
        repeats=7,
    )
    peak = rounds * 8 * 8 * 2 / seconds["peak"]
    stream = CALLS * 2 * band.nbytes / seconds["copy"]
    yield Row("budget", "peak of one core, multiply-adds on registers", peak / 1e9, "Gflop/s")
    yield Row(
        "budget", f"copy of {band.nbytes / 1e3:.0f} kB, read and written", stream / 1e9, "GB/s"
    )
    # A quadrature point of the bilinear element, three shape functions: gradient 3 x 8, strains 11,
    # stresses 18, their products 16, forces 3 x 8.
    point = 24 + 11 + 18 + 16 + 24
    entries = band.nbytes // 8 // STATES
    columns = np.minimum(depth - 1, n - 1 - np.arange(n))  # entries below each diagonal
    counts = {
        "force": (
            elements * (4 * point + 12),
            8 * (2 * n + force.table.shape[0] * elements / STATES),
        ),
        # Gradient 24, strains and stresses 22, the elasticity tensor 49, its products with three
        # shape functions 72, and 21 entries of 4; the fourth by sums.
        "tangent": (
            elements * (4 * (24 + 22 + 49 + 72 + 21 * 4) + 57),
            8 * (n + 2 * entries + force.table.shape[0] * elements / STATES),
        ),
        "factor": (int((columns * (columns + 1) + columns + 3).sum()), 8 * 4 * entries),
        "solve": (int((4 * columns + 2).sum()), 8 * (2 * entries + 4 * n)),
    }
    for name, (flops, size) in counts.items():
        each = seconds[name] / CALLS / STATES
        yield Row("budget", f"{name}: time for one of {STATES} states", 1e6 * each, "us")
        yield Row(
            "budget",
            f"{name}: {flops} flops a state",
            flops / each / 1e9,
            "Gflop/s",
            "measured peak",
            peak / 1e9,
            "higher",
        )
        yield Row(
            "budget",
            f"{name}: {size:.0f} bytes a state",
            size / each / 1e9,
            "GB/s",
            "measured copy",
            stream / 1e9,
            "higher",
        )
