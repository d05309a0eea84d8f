"""Work of several threads, in code that lets go of the interpreter: LAPACK, sparse products and
kernels with `nogil`.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

LARGE = 4000  # displacements, or points at which forces are summed up
Item, Result = TypeVar("Item"), TypeVar("Result")


def threads() -> int:
    """What OMP_NUM_THREADS says, as for other numerical libraries; without it all cores. Of a list,
    which is for threads within threads, it is the first number.
    """
    outer = os.environ.get("OMP_NUM_THREADS", "").partition(",")[0].strip()
    return (int(outer) if outer.isdecimal() else 0) or os.cpu_count() or 1


def worth(size: int) -> int:
    """Threads for bodies of this size: small ones wait for one another more than they compute."""
    return threads() if size >= LARGE else 1


def mapped(
    function: Callable[[Item], Result], items: Iterable[Item], count: int | None = None
) -> list[Result]:
    """The function of every item, each for itself, on `count` threads; None: on all."""
    count = threads() if count is None else count
    if count == 1:
        return [function(item) for item in items]
    with ThreadPoolExecutor(count) as pool:
        return list(pool.map(function, items))
