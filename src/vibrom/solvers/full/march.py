"""Step after step: what a time loop knows whatever the method, namely records, failures, progress.

A method is a `Stepper`, which knows one step. It carries a batch of states through a chunk of
steps, and leaves what is to be kept in a `Store`; `march` moves that into the motion. `keep` is
called after each step, from compiled loops and from Python.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, Protocol

import numpy as np

from vibrom.kernels.compiled import Blocks, Numbers, Rows, part
from vibrom.solvers.full.motion import Motion, Record


class State(NamedTuple):
    """Where a batch of states is."""

    q: Rows  # (n, width) m
    v: Rows  # (n, width) m/s
    a: Rows  # (n, width) m/s^2


class Span(NamedTuple):
    """A chunk of steps. Its first step belongs to the chunk before, but for step 0."""

    first: int
    last: int


class Store(NamedTuple):
    """What is to be kept, and room for what a chunk of steps leaves."""

    every: int
    start: int
    probes: Numbers  # (k,)
    q: Blocks  # (records, n, width) m
    v: Blocks  # (records, n, width) m/s
    a: Blocks  # (records, n, width) m/s^2
    watched: Blocks  # (steps of the chunk + 1, k, width) m


class Stepper(Protocol):
    """A batch of states, and a method that carries it from step to step."""

    chunk: int  # steps between two reports of progress
    width: int  # states side by side
    failed: np.ndarray  # (width,) step at which each state failed, -1: none
    iterations: np.ndarray  # (1,) so far
    factorisations: np.ndarray  # (1,) so far

    @staticmethod
    def compile(term: Term, width: int) -> None:
        """Compiles what a batch of `width` states needs, or reads it from disk."""
        ...

    def __init__(self, batch: Batch, limits: Limits, half: int): ...

    def advance(self, span: Span, store: Store) -> int:
        """Carries the states over a span; returns how many records are in the store."""
        ...


def chunk(n: int, width: int) -> int:
    """Steps between two reports of progress, so that what they leave stays below 100 MB."""
    return int(np.clip(4_000_000 // (n * width), 10, 2000))


@part
def keep(step, span, state, store, stored):
    """Stores what is wanted of this step; returns how many records there are then."""
    if step == span.first and step > 0:
        return stored
    for k in range(store.probes.shape[0]):
        for w in range(state.q.shape[1]):
            store.watched[step - span.first, k, w] = state.q[store.probes[k], w]
    if step < store.start or (step - store.start) % store.every:
        return stored
    for i in range(state.q.shape[0]):
        for w in range(state.q.shape[1]):
            store.q[stored, i, w], store.v[stored, i, w] = state.q[i, w], state.v[i, w]
            store.a[stored, i, w] = state.a[i, w]
    return stored + 1


def march(
    stepper: Stepper,
    steps: int,
    record: Record,
    motion: Motion,
    where: slice,
    progress: Callable[[int], None] | None,
) -> None:
    """Carries a batch over all steps and fills the states `where` of the motion; further states of
    the batch are ignored.
    """
    live, n = where.stop - where.start, motion.displacement.shape[2]
    store = _room(record, min(stepper.chunk, steps), n, stepper.width)
    for first in range(0, steps, stepper.chunk):
        span = Span(first, min(first + stepper.chunk, steps))
        stored = stepper.advance(span, store)
        _move(store, stored, span, record, motion, where)
        if progress is not None:
            progress((span.last - span.first) * live)
    for state, failed in zip(range(where.start, where.stop), stepper.failed):
        if failed >= 0:
            motion.failed_at[state] = failed
            for values in (motion.displacement, motion.velocity, motion.acceleration):
                values[state, motion.kept >= failed] = np.nan
            motion.probes[state, :, max(failed - record.probe_start, 0) :] = np.nan
    motion.iterations += int(stepper.iterations[0])
    motion.factorisations += int(stepper.factorisations[0])


def _room(record: Record, steps: int, n: int, width: int) -> Store:
    probes = np.ascontiguousarray(record.probes, dtype=np.int64)
    records = np.zeros((3, steps // record.every + 2, n, width))
    return Store(
        record.every, record.start, probes, *records, np.zeros((steps + 1, len(probes), width))
    )


def _move(
    store: Store, stored: int, span: Span, record: Record, motion: Motion, where: slice
) -> None:
    """From the store into the motion."""
    live = where.stop - where.start
    first = span.first if span.first == 0 else span.first + 1
    begin = int(np.searchsorted(motion.kept, first))
    for values, rows in (
        (motion.displacement, store.q),
        (motion.velocity, store.v),
        (motion.acceleration, store.a),
    ):
        values[where, begin : begin + stored] = rows[:stored, :, :live].transpose(2, 0, 1)
    steps = np.arange(max(first, record.probe_start), span.last + 1)
    watched = store.watched[steps - span.first, :, :live]
    motion.probes[where, :, steps - record.probe_start] = watched.transpose(2, 1, 0)
