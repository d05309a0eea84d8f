"""Recorded samples, as the rows of a matrix that may be larger than memory.

What a fit needs of them are sums over rows or columns, which are added up a block at a time. Those
that are small are one block, and in memory.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

BLOCK = 2**25  # bytes of the largest block
SPARE = 50  # directions that are kept beside those that are wanted


@dataclass(frozen=True)
class Samples:
    """(m, k): motions one below the other, of each some arrays side by side. An array may be a
    variable of a file, which is read where it is sliced.
    """

    motions: tuple[tuple[Any, ...], ...]

    @property
    def shape(self) -> tuple[int, int]:
        """(m, k)."""
        rows = sum(len(beside[0]) for beside in self.motions)
        return rows, sum(part.shape[1] for part in self.motions[0])

    @property
    def _blocks(self) -> int:
        m, k = self.shape
        return -(-8 * m * k // BLOCK)

    def blocks(self) -> Iterator[np.ndarray]:
        """All rows, some of them at a time."""
        if self._blocks <= 1:
            yield _joined([_beside(beside, slice(None)) for beside in self.motions], axis=0)
            return
        count = max(1, self.shape[0] // self._blocks)
        for beside in self.motions:
            for first in range(0, len(beside[0]), count):
                yield _beside(beside, slice(first, first + count))

    def columns(self) -> Iterator[tuple[slice, np.ndarray]]:
        """All columns, some of them at a time, and which these are."""
        first = 0
        for parts in zip(*self.motions):
            width = parts[0].shape[1]
            step = max(1, width // max(1, self._blocks))
            for begin in range(0, width, step):
                some = slice(begin, min(begin + step, width))
                block = _joined([np.asarray(part[:, some], float) for part in parts], axis=0)
                yield slice(first + some.start, first + some.stop), block
            first += width

    def __matmul__(self, right: np.ndarray) -> np.ndarray:
        """(m, r) of a matrix (k, r)."""
        return self.map(lambda block: block @ right)

    def map(self, function: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
        """What a function makes of the rows, each for itself."""
        return _joined([function(block) for block in self.blocks()], axis=0)

    def all(self, condition: Callable[[np.ndarray], Any]) -> bool:
        """Does it hold of all rows?"""
        return all(np.all(condition(block)) for block in self.blocks())

    def norm(self) -> float:
        """Root of the sum of all squares."""
        return float(np.linalg.norm([np.linalg.norm(block) for block in self.blocks()]))

    def thinned(self, every: int) -> Samples:
        """Every k-th row of each motion."""
        return Samples(tuple(tuple(part[::every] for part in beside) for beside in self.motions))


def rows(*arrays: Any) -> Iterator[tuple[np.ndarray, ...]]:
    """The same rows (k, n) of each array (m, n), some at a time; k = m where they are small."""
    width = 8 * int(np.prod(arrays[0].shape[1:]))
    count = max(1, BLOCK // max(1, width))
    for first in range(0, len(arrays[0]), count):
        yield tuple(np.asarray(array[first : first + count], float) for array in arrays)


def directions(blocks: Iterator[np.ndarray], count: int) -> tuple[np.ndarray, np.ndarray]:
    """The first singular values (r,) and right singular vectors (r, k) of rows that come in blocks.

    Those of what came before, times their values, stand for it: [S V'; block] has the singular
    values and right singular vectors of all rows. Beyond the `count` that are wanted, SPARE are
    carried on.
    """
    values, vectors = _decomposed(next(blocks))
    for block in blocks:
        kept = slice(count + SPARE)
        values, vectors = _decomposed(np.vstack([values[kept, None] * vectors[kept], block]))
    return values, vectors


def _decomposed(rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    # There are often many more rows than columns, and the left vectors are not wanted: with Q R the
    # rows, R has their singular values and right singular vectors.
    return np.linalg.svd(np.linalg.qr(rows, mode="r"), full_matrices=False)[1:]


def _beside(parts: tuple[Any, ...], some: slice) -> np.ndarray:
    return _joined([np.asarray(part[some], float) for part in parts], axis=1)


def _joined(arrays: list[np.ndarray], axis: int) -> np.ndarray:
    return arrays[0] if len(arrays) == 1 else np.concatenate(arrays, axis=axis)
