"""Functions that run when a kernel is compiled compute what plain arithmetic computes."""

import numpy as np
import pytest
from numba import njit
from numba.core.errors import TypingError

from vibrom.kernels.compiled import edition
from vibrom.kernels.lanes import WIDTH, get, put
from vibrom.kernels.unrolled import sum_of, unrolled


@unrolled
def product(x, y):
    """x_ik y_kj of matrices by rows."""
    size = round(len(x) ** 0.5)
    return tuple(
        sum_of(x[size * i + k] * y[size * k + j] for k in range(size))
        for i in range(size)
        for j in range(size)
    )


@unrolled
def rows(array, first, count, width):
    return tuple(array.get(first + i, width) for i in range(count))


@unrolled
def store(array, first, values):
    for i, value in enumerate(values):
        array.put(first + 2 * i, 1.0 - 2 * (value + 0.5) * 1.0 - value)


@unrolled
def entries(table, first, e, states):
    return tuple(table.entry(first + i, e, states) for i in range(2))


@pytest.mark.parametrize("size", [2, 3])
@pytest.mark.parametrize("width", [1, 4, 8])
def test_loops_over_tuples_and_rows(size, width):
    count = size * size

    @njit
    def run(x, y, first, out):
        made = product(rows(x, first, count, width), rows(y, 0, count, width))
        store(out, first, made)

    rng = np.random.default_rng(0)
    x, y = rng.standard_normal((2, count + 1, width))
    out = np.zeros((2 * count + 1, width))
    run(x, y, 1, out)
    left, right = x[1:].reshape(size, size, width), y[:-1].reshape(size, size, width)
    made = np.einsum("ikw,kjw->ijw", left, right).reshape(count, width)
    np.testing.assert_allclose(out[1::2], -3 * made, atol=1e-14)
    assert not out[::2].any()


@pytest.mark.parametrize("states", [1, 8])
def test_entries_are_those_of_one_element_or_of_eight(states):
    @njit
    def run(table, first, e, out):
        one, two = entries(table, first, e, states)
        put(out, 0, one)
        put(out, 1, two)

    table, out = np.arange(60.0).reshape(3, 20), np.zeros((2, WIDTH))
    run(table, 1, 5, out)
    expected = table[1:3, 5 : 5 + WIDTH] if states == 1 else table[1:3, 5:6] + np.zeros(WIDTH)
    assert np.array_equal(out, expected)


def test_an_edit_of_one_is_an_edit_of_its_kernel():
    def kernel(x):
        put(x, 0, product((get(x, 0, 8),), (get(x, 0, 8),))[0])

    def other(x):
        put(x, 0, get(x, 0, 8))

    assert edition(kernel) != edition(other)


def test_what_is_no_lanes_is_said():
    @unrolled
    def wrong(array, first):
        return first + 1

    @njit
    def run(x, first):
        wrong(x, first)

    with pytest.raises(TypingError, match="an unrolled function returns lanes, not Place"):
        run(np.zeros((2, 8)), 1)
