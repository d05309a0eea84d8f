"""From batch to batch and chunk to chunk: what is done around the steps of any method."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np

from vibrom.kernels.compiled import passing_kernels
from vibrom.solvers.full.batch import Batch
from vibrom.solvers.full.motion import Motion, Observer, Record
from vibrom.solvers.full.newton import Limits
from vibrom.solvers.full.stepper import Stepper
from vibrom.solvers.full.store import Span, Store


def integrate(
    method: type[Stepper],
    start: Batch,
    limits: Limits,
    half: int,
    record: Record,
    progress: Callable[[int], None] | None,
) -> Motion:
    """Carries all states over all steps of their signal, one batch after the other."""
    states, steps = start.width, len(start.signal) - 1
    motion, first = record.allocate(start.term.size, states, steps), 0
    while first < states:
        width = 1 if start.more else method.batch_width(states - first)
        where = slice(first, min(first + width, states))
        with passing_kernels():
            method.compile(start, width)
            began = time.perf_counter()
            stepper = method(start.part(first, width), limits, half)
            motion.seconds += time.perf_counter() - began
            march(stepper, steps, record, motion, where, progress)
        first = where.stop
    motion.failed_at *= start.h
    return motion


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
    for first in range(0, max(steps, 1), stepper.chunk):
        span = Span(first, min(first + stepper.chunk, steps))
        began = time.perf_counter()
        stored = stepper.advance(span, store)
        motion.seconds += time.perf_counter() - began
        _move(store, stored, span, stepper.failed, record, motion, where)
        if record.observer is not None:
            _show(store, span, record.observer, where)
        if progress is not None:
            progress((span.last - span.first) * live)
    for state, failed in zip(range(where.start, where.stop), stepper.failed):
        if failed >= 0:
            motion.failed_at[state] = failed
    motion.iterations += int(stepper.iterations[0])
    motion.factorisations += int(stepper.factorisations[0])


def _room(record: Record, steps: int, n: int, width: int) -> Store:
    probes = np.ascontiguousarray(record.probes, dtype=np.int64)
    records = np.zeros((3, steps // record.every + 2, n, width))
    watched = np.zeros((steps + 1, len(probes), width))
    apart = 0 if record.observer is None else record.observer.apart
    shown = np.zeros((3, steps // apart + 2 if apart else 0, n, width))
    return Store(record.every, record.start, probes, *records, watched, apart, *shown)


def _show(store: Store, span: Span, observer: Observer, where: slice) -> None:
    """To the observer, what the steps of a span have left."""
    apart, live = store.apart, where.stop - where.start
    first = span.first if span.first == 0 else span.first + 1
    numbers = np.arange(-(-first // apart) * apart, span.last + 1, apart)
    if not len(numbers):
        return
    rows = numbers // apart - span.first // apart
    parts = (part[rows, :, :live] for part in (store.seen_q, store.seen_v, store.seen_a))
    observer.see(numbers, where, *parts)


def _move(
    store: Store,
    stored: int,
    span: Span,
    failed: np.ndarray,
    record: Record,
    motion: Motion,
    where: slice,
) -> None:
    """From the store into the motion or the sink; NaN from the step on at which a state `failed`,
    -1: none.
    """
    live = where.stop - where.start
    first = span.first if span.first == 0 else span.first + 1
    begin = int(np.searchsorted(motion.kept, first))
    kept = motion.kept[begin : begin + stored]
    states = [rows[:stored, :, :live] for rows in (store.q, store.v, store.a)]
    for state in np.flatnonzero(failed[:live] >= 0):
        for rows in states:
            rows[kept >= failed[state], :, state] = np.nan
        store.watched[max(failed[state] - span.first, 0) :, :, state] = np.nan
    if record.sink is not None:
        record.sink.see(kept, where, *states)
    else:
        for values, rows in zip(
            (motion.displacement, motion.velocity, motion.acceleration), states
        ):
            values[where, begin : begin + stored] = rows.transpose(2, 0, 1)
    steps = np.arange(max(first, record.probe_start), span.last + 1)
    watched = store.watched[steps - span.first, :, :live]
    motion.probes[where, :, steps - record.probe_start] = watched.transpose(2, 1, 0)
