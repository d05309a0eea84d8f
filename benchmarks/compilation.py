"""Compilation, timed apart.

The first process that meets a body compiles its kernels and keeps them on disk; the second reads
them. Both run ten steps of the folding cantilever (one state, then sixteen) from an empty store; a
third with the other element compiles that element's kernels alone. No time on this page contains
compilation: `Newmark` and the experiments compile before their clocks start.
"""

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator

from benchmarks.table import Row

CODE = """
import json, sys, time
began = time.perf_counter()
import numpy as np
from numba.core import event
from benchmarks.cantilever import NEWMARK, build
seen = []
class Listener(event.Listener):
    def on_start(self, event): seen.append(event.data["dispatcher"].py_func.__qualname__)
    def on_end(self, event): pass
event.register("numba:compile", Listener())
model = build(element=sys.argv[1])
for states in (1, 16):
    NEWMARK.run(model.term, np.zeros((model.space.size, states)), np.full(states, 1e-5), 10)
print(json.dumps([time.perf_counter() - began, len(seen)]))
"""


def measure(note) -> Iterator[Row]:
    with tempfile.TemporaryDirectory() as store:

        def process(element: str) -> tuple[float, int]:
            run = subprocess.run(
                [sys.executable, "-c", CODE, element],
                env=os.environ | {"NUMBA_CACHE_DIR": store},
                stdout=subprocess.PIPE,
                text=True,
                check=True,
            )
            return json.loads(run.stdout)

        first, second, other = process("bilinear"), process("bilinear"), process("quadratic")
    yield Row(
        "compilation",
        "a process that finds its kernels on disk, imports and ten steps",
        second[0],
        "s",
        "the first process, which compiles them",
        first[0],
    )
    yield Row(
        "compilation",
        "functions compiled by the second process",
        float(second[1]),
        "1",
        "by the first",
        float(first[1]),
    )
    yield Row(
        "compilation",
        "the first process with the other element",
        other[0],
        "s",
        "the first process of all",
        first[0],
    )
    yield Row(
        "compilation",
        "functions compiled for the other element",
        float(other[1]),
        "1",
        "by the first of all",
        float(first[1]),
    )
