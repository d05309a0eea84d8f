"""A full-order response curve, frequencies side by side.

33 frequencies of 200 periods with 1000 steps each, from rest, at the folding forcing: 6.6 million
state-steps. Sixteen states side by side fill the lanes of two registers; one state has its elements
in the lanes. Both do the same sixteen over the first 20 periods on one core, side by side or one
after the other. Off resonance a state alone needs fewer iterations than the slowest of a batch, at
resonance more than the average.

How much a batch gains depends on the processor. A batch is limited by arithmetic and by the second
cache (its arrays take 1 MB), one state alone by latency, as a column of its narrow band waits for
the one before. Registers of 256 bits therefore slow down the batch alone: the last pair is compiled
for them. So does another thread on the same core, which halves arithmetic and cache of a batch and
fits into the waiting of a single state.

The whole curve runs once, in two processes on two cores, as two jobs of the workflow do.
"""

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator

import numpy as np

from benchmarks.cantilever import NEWMARK, SCENE, STEPS_PER_PERIOD, build
from benchmarks.table import Row, paired
from vibrom.solvers.full.newmark import Motion, Record

CURVE = SCENE["experiments"]["frc"]
ALL = np.linspace(CURVE["lowest"], CURVE["highest"], CURVE["frequencies"])
SIXTEEN = {"low": ALL[:16], "at resonance": ALL[9:25], "high": ALL[-16:]}
PERIODS = 20
# Of numba: instructions of a processor whose registers hold four doubles.
NARROW = {"NUMBA_CPU_NAME": "haswell", "NUMBA_CPU_FEATURES": ""}


def run(frequencies: np.ndarray, periods: int) -> Motion:
    model, steps = build(), periods * STEPS_PER_PERIOD
    frequencies = frequencies * model.frequency
    phase = 2 * np.pi * np.arange(steps + 1)[:, None] / STEPS_PER_PERIOD
    return NEWMARK.run(
        model.term,
        np.zeros((model.space.size, len(frequencies))),
        2 * np.pi / (frequencies * STEPS_PER_PERIOD),
        steps,
        signal=CURVE["forcing"] * np.sin(phase) * np.ones(len(frequencies)),
        initial_acceleration="zero",
        record=Record(start=steps + 1),
    )


def side_by_side_and_alone(which: str) -> dict[str, float]:
    """Seconds of the same sixteen frequencies."""
    some = SIXTEEN[which]
    calls = {
        "batch": lambda: run(some, PERIODS),
        "one": lambda: [run(one, PERIODS) for one in some[:, None]],
    }
    return paired(calls, repeats=3)


def narrow(which: str) -> dict[str, float]:
    """The same, compiled for registers of 256 bits, by a process of its own."""
    with tempfile.TemporaryDirectory() as store:
        found = subprocess.run(
            [sys.executable, "-m", "benchmarks.sweep", which],
            env=os.environ | NARROW | {"NUMBA_CACHE_DIR": store},
            stdout=subprocess.PIPE,
            check=True,
            text=True,
        )
    return json.loads(found.stdout)


def measure(note) -> Iterator[Row]:
    for which in SIXTEEN:
        note(f"{PERIODS} periods of 16 frequencies, {which}")
        yield compared(which, side_by_side_and_alone(which))
    note("the same at resonance, compiled for registers of 256 bits")
    yield compared("at resonance, 256-bit registers", narrow("at resonance"))
    note("the whole curve on two cores")
    began = time.perf_counter()
    halves = [
        subprocess.Popen([sys.executable, "-m", "benchmarks.sweep", half]) for half in ("0", "1")
    ]
    if any(half.wait() for half in halves):
        raise RuntimeError("half of the curve failed")
    seconds = time.perf_counter() - began
    state_steps = len(ALL) * CURVE["periods"] * STEPS_PER_PERIOD
    text = f"33 frequencies x {CURVE['periods']} periods x {STEPS_PER_PERIOD} steps on two cores"
    yield Row("sweep", text, seconds, "s", "the thesis (another machine)", 75 * 3600.0)
    yield Row("sweep", "state-steps per second on two cores", state_steps / seconds, "1/s")


def compared(which: str, seconds: dict[str, float]) -> Row:
    batch, one = (16 * PERIODS * STEPS_PER_PERIOD / seconds[name] for name in ("batch", "one"))
    text = f"state-steps per second and core, sixteen {which}"
    return Row("sweep", text, batch, "1/s", "one state at a time", one, "higher")


if __name__ == "__main__":
    if sys.argv[1] in SIXTEEN:
        print(json.dumps(side_by_side_and_alone(sys.argv[1])))
    else:
        # Neighbours share their resonance: frequencies that alternate would spread it over both
        # halves.
        run(ALL[:16] if sys.argv[1] == "0" else ALL[16:], CURVE["periods"])
