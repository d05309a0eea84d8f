"""What a method of time integration must offer: one class that knows one step.

`march` knows the rest, whatever the method: batches, records, failures, progress.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np

from vibrom.solvers.full.batch import Batch
from vibrom.solvers.full.newton import Limits
from vibrom.solvers.full.store import Span, Store


class Stepper(Protocol):
    """A batch of states, and a method that carries it from step to step."""

    chunk: int  # steps between two reports of progress
    width: int  # states side by side
    failed: np.ndarray  # (width,) step at which each state failed, -1: none
    iterations: np.ndarray  # (1,) so far
    factorisations: np.ndarray  # (1,) so far

    @staticmethod
    def compile(batch: Batch, width: int) -> None:
        """Compiles what `width` states of a batch need, or reads it from disk."""
        ...

    @staticmethod
    def batch_width(remaining: int) -> int:
        """How many of the remaining states go side by side."""
        ...

    def __init__(self, batch: Batch, limits: Limits, half: int): ...

    def advance(self, span: Span, store: Store) -> int:
        """Carries the states over a span and keeps what the store asks for (`store.keep`); returns
        how many records there are.
        """
        ...
