"""Lanes do for each state what plain arithmetic does for one."""

import importlib
import os
import subprocess
import sys
from collections import namedtuple
from typing import NamedTuple

import numpy as np
import pytest
from numba import njit, types
from numba.core.caching import CacheImpl
from numba.core.errors import TypingError

from vibrom.kernels.compiled import Rows, Vector, kernel, machine_type
from vibrom.kernels.lanes import (
    WIDTH,
    cut,
    edition,
    entry,
    fill,
    floor,
    get,
    paste,
    positive,
    power_of_two,
    put,
    room,
    sqrt,
    stack,
)


def evaluate(width, function, *rows):
    """function of lanes loaded from each row (width,)."""
    if len(rows) == 1:

        @njit
        def run(arrays, out):
            put(out, 0, function(get(arrays, 0, width)))
    else:

        @njit
        def run(arrays, out):
            put(out, 0, function(get(arrays, 0, width), get(arrays, 1, width)))

    out = np.zeros((1, width))
    run(np.stack(rows), out)
    return out[0]


OPERATIONS = {
    "sum": lambda x, y: x + y,
    "difference": lambda x, y: x - y,
    "product": lambda x, y: x * y,
    "quotient": lambda x, y: x / y,
    "number on the left": lambda x, y: 2.0 / x - 3 * y,
    "number on the right": lambda x, y: (x - 1.5) * 2 + y,
}


@pytest.mark.parametrize("width", [1, 2, 3, 8])
@pytest.mark.parametrize("name", OPERATIONS)
def test_arithmetic(name, width):
    x, y = np.random.default_rng(1).uniform(0.5, 2.0, (2, width))
    function = OPERATIONS[name]
    # Two roundings, or one where a product and a sum became one instruction.
    np.testing.assert_allclose(
        evaluate(width, njit(function), x, y), function(x, y), rtol=1e-14, atol=1e-15
    )


def test_root_negative_and_growing_sums():
    @njit
    def function(x):
        y = fill(1.0, 8)
        y += x
        y -= 0.5
        y *= x
        y /= 4.0
        return 0.0 - sqrt(y)

    x = np.linspace(0.0, 3.0, 8)
    np.testing.assert_allclose(evaluate(8, function, x), -np.sqrt((0.5 + x) * x / 4.0), rtol=1e-14)


def test_a_lane_that_is_not_a_number_spoils_no_other():
    x = np.array([1.0, np.nan, -1.0, np.inf])
    expected = np.sqrt(x, where=x >= 0, out=np.full(4, np.nan))
    np.testing.assert_array_equal(evaluate(4, njit(lambda x: sqrt(x)), x), expected)


@pytest.mark.parametrize("states", [1, 4])
def test_entries_are_shared_by_states_and_differ_between_elements(states):
    width = WIDTH if states == 1 else states

    @njit
    def run(table, out):
        put(out, 0, entry(table, 1, 3, states))

    table, out = np.arange(40.0).reshape(2, 20), np.zeros((1, width))
    run(table, out)
    np.testing.assert_array_equal(
        out[0], table[1, 3 : 3 + width] if states == 1 else np.full(states, table[1, 3])
    )


def test_choices_and_powers_of_two():
    @njit
    def choose(x):
        return positive(x - 1.0, x, -2.0)

    @njit
    def scale(x):
        return power_of_two(floor(x))

    x = np.array([0.5, 1.5, np.nan, -3.0])
    np.testing.assert_array_equal(evaluate(4, choose, x), [-2.0, 1.5, -2.0, -2.0])
    np.testing.assert_array_equal(
        evaluate(4, scale, np.array([0.9, -1.2, 1000.0, -1022.0])),
        [1.0, 0.25, 2.0**1000, 2.0**-1022],
    )


def test_lanes_from_any_place():
    @njit
    def shift(x):
        paste(x, 3, cut(x, 1, 4))

    x = np.arange(9.0)
    shift(x)
    np.testing.assert_array_equal(x, [0, 1, 2, 1, 2, 3, 4, 7, 8])


@pytest.mark.parametrize("make", [room, njit(lambda rows, width: room(rows, width))])
def test_rooms_begin_at_a_cache_line(make):
    rooms = [make(rows, width) for rows in (1, 7, 5000) for width in (1, 8, 16)]
    assert all(one.ctypes.data % 64 == 0 and one.flags.c_contiguous for one in rooms)
    assert [one.shape for one in rooms] == [
        (rows, width) for rows in (1, 7, 5000) for width in (1, 8, 16)
    ]


@pytest.mark.parametrize("states", [1, 8, 16])
def test_rows_on_the_stack_hold_what_was_put_there(states):
    """Two arrays of one kernel are two, from a cache line on each; a second call starts again."""

    @njit
    def run(x):
        first, second = stack(3, states), stack(2, states)
        for i in range(3):
            put(first, i, get(x, i, states) * 2.0)
        put(second, 0, get(first, 2, states))
        put(second, 1, get(first, 0, states))
        for i in range(2):
            put(x, i, get(second, i, states))
        return first.shape, first.ctypes.data % 64, second.ctypes.data % 64

    x = np.arange(3.0 * states).reshape(3, states)
    expected = 2.0 * x[[2, 0]]
    assert run(x) == ((3, states), 0, 0)
    np.testing.assert_array_equal(x[:2], expected)
    assert run(x) == ((3, states), 0, 0)


def test_lanes_and_rows_on_the_stack_are_counted_when_a_kernel_is_compiled():
    @njit
    def rows(number):
        return stack(number, 8)[0, 0]

    @njit
    def width(x, number):
        return put(x, 0, get(x, 0, number))

    for call in (lambda: rows(3), lambda: width(np.zeros((1, 8)), 8)):
        with pytest.raises(TypingError, match="must be counted when a kernel is compiled"):
            call()


def test_only_lanes_of_one_width_go_together_and_arrays_are_contiguous():
    @njit
    def mixed(x):
        return get(x, 0, 4) + get(x, 1, 8)

    @njit
    def number(x):
        put(x, 0, 1.0)

    with pytest.raises(TypingError, match="do not go together"):
        mixed(np.zeros((2, 8)))
    with pytest.raises(TypingError, match="contiguous float64"):
        mixed(np.zeros((2, 8)).T)
    with pytest.raises(TypingError, match="fill them"):
        number(np.zeros((2, 8)))


# As the time loop calls it.
FACTORISE = """
import sys
import numpy as np
from numba import njit, types
from vibrom.kernels.banded import kernels
band = types.float64[:, :, ::1]
pointer = types.FunctionType(types.void(band))
call = njit([types.void(pointer, band)])(lambda function, matrix: function(matrix))
for width in map(int, sys.argv[1:]):
    matrix = np.full((5, 1, width), 4.0)
    call(kernels(width).factorise, matrix)
    assert np.array_equal(matrix, np.full((5, 1, width), 0.25)), (width, matrix)
"""


def test_specialisations_of_several_processes_are_told_apart(tmp_path):
    """Each width is compiled by a process of its own; one that finds both on disk must call the
    right one.
    """
    for widths in ("3", "2", "2 3 2"):
        subprocess.run(
            [sys.executable, "-c", FACTORISE, *widths.split()],
            check=True,
            env=os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)},
        )


HELPERS = {
    "helper_of_a_helper": """
from {home} import {name} as made

@made
def once(x):
    return 2.0 * x
""",
    "helper_of_a_kernel": """
from {home} import {name} as made
from helper_of_a_helper import once

@made
def twice(x):
    return 2.0 * once(x)
""",
}


@pytest.mark.parametrize("changed", HELPERS)
@pytest.mark.parametrize(
    "maker", ["numba.njit", "numba.extending.register_jitable", "vibrom.kernels.lanes.part"]
)
def test_a_kernel_on_disk_is_that_of_the_files_it_calls(tmp_path, monkeypatch, maker, changed):
    """Else an edited helper, or a helper's helper, would stay as it was in every kernel."""
    home, _, name = maker.rpartition(".")
    monkeypatch.syspath_prepend(tmp_path)
    for helper, text in HELPERS.items():
        (tmp_path / f"{helper}.py").write_text(text.format(home=home, name=name))
        monkeypatch.delitem(sys.modules, helper, raising=False)
    calls = {"twice": importlib.import_module("helper_of_a_kernel").twice}
    exec("def kernel(x):\n    return twice(x)\n\n\ndef other(x):\n    return 2.0 * x\n", calls)
    before, alone = edition(calls["kernel"]), edition(calls["other"])
    path = tmp_path / f"{changed}.py"
    path.write_text(path.read_text().replace("2.0", "3.0"))
    assert edition(calls["kernel"]) != before
    assert edition(calls["other"]) == alone


class Settings(NamedTuple):
    """A record of compiled code."""

    start: float
    count: int
    values: Rows


class Pair(NamedTuple):
    """A record in a record."""

    first: Settings
    second: Vector


def test_a_record_says_its_machine_type_and_a_kernel_on_disk_is_that_of_its_fields():
    """Two fields of one type that change places would be read in the wrong place."""
    kind = machine_type(Pair)
    inner = types.NamedTuple([types.float64, types.int64, types.float64[:, ::1]], Settings)
    assert kind == types.NamedTuple([inner, types.float64[::1]], Pair)
    pair = Pair(Settings(2.0, 3, np.ones((2, 2))), np.full(1, 5.0))

    @njit([types.float64(kind)])
    def use(pair):
        return pair.first.start * pair.first.count + pair.first.values[1, 1] + pair.second[0]

    assert use(pair) == 12.0
    straight, turned = (
        types.NamedTuple([types.float64, types.int64], namedtuple("Fields", names))
        for names in ("rate count", "count rate")
    )
    editions = {edition(use.py_func, types.void(kind)) for kind in (straight, turned)}
    assert len(editions) == 2


def test_where_nothing_can_be_kept_on_disk_kernels_are_compiled_each_time(monkeypatch):
    """As in a package that may only be read, of a user without a home."""
    monkeypatch.setattr(CacheImpl, "_locator_classes", [])

    @kernel(types.float64(types.float64))
    def twice(x):
        return 2.0 * x

    assert twice(1.5) == 3.0
