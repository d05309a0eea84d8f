"""What a time loop carries and leaves: the state of a batch, and what is kept of its steps."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from vibrom.kernels.compiled import Blocks, Numbers, Rows, part
from vibrom.kernels.lanes import get, put
from vibrom.solvers.full.scheme import ended


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
    apart: int  # steps between the states that are shown to an observer; 0: there is none
    seen_q: Blocks  # (shown, n, width) m
    seen_v: Blocks  # (shown, n, width) m/s
    seen_a: Blocks  # (shown, n, width) m/s^2


def chunk(n: int, width: int) -> int:
    """Steps between two reports of progress, so that what they leave stays below 100 MB."""
    return int(np.clip(4_000_000 // (n * width), 10, 2000))


@part
def copy(state, into, width):
    """A state into another."""
    for i in range(state.q.shape[0]):
        put(into.q, i, get(state.q, i, width))
        put(into.v, i, get(state.v, i, width))
        put(into.a, i, get(state.a, i, width))


@part
def finish_step(scheme, start, state, width):
    """The step's end, from the instant where the equation of motion holds."""
    for i in range(state.q.shape[0]):
        q, v, a = get(state.q, i, width), get(state.v, i, width), get(state.a, i, width)
        put(state.q, i, ended(scheme.alpha_f, get(start.q, i, width), q))
        put(state.v, i, ended(scheme.alpha_f, get(start.v, i, width), v))
        put(state.a, i, ended(scheme.alpha_m, get(start.a, i, width), a))


@part
def keep(step, span, state, store, stored):
    """Stores what is wanted of this step; returns how many records there are then."""
    if step == span.first and step > 0:
        return stored
    for k in range(store.probes.shape[0]):
        for w in range(state.q.shape[1]):
            store.watched[step - span.first, k, w] = state.q[store.probes[k], w]
    if store.apart > 0 and step % store.apart == 0:
        shown = step // store.apart - span.first // store.apart
        for i in range(state.q.shape[0]):
            for w in range(state.q.shape[1]):
                store.seen_q[shown, i, w], store.seen_v[shown, i, w] = state.q[i, w], state.v[i, w]
                store.seen_a[shown, i, w] = state.a[i, w]
    if step < store.start or (step - store.start) % store.every:
        return stored
    for i in range(state.q.shape[0]):
        for w in range(state.q.shape[1]):
            store.q[stored, i, w], store.v[stored, i, w] = state.q[i, w], state.v[i, w]
            store.a[stored, i, w] = state.a[i, w]
    return stored + 1
