"""A full-order response curve, frequencies side by side.

33 frequencies of 200 periods with 1000 steps each, from rest, at the folding forcing: 6.6 million
state-steps. Sixteen states side by side fill the lanes of two registers; one state has its elements
in the lanes. Both do the same sixteen, side by side or one after the other, over the first 20
periods on one core: off resonance a state alone needs fewer iterations than the slowest of a batch,
at resonance more than the average. The whole curve runs once, in two processes on two cores, as two
jobs of the workflow do.
"""

import subprocess
import sys
import time
from collections.abc import Iterator

import numpy as np

from benchmarks.cantilever import NEWMARK, SCENE, STEPS_PER_PERIOD, build
from benchmarks.table import Row, paired
from vibrom.solvers.full.newmark import Motion, Record

CURVE = SCENE["experiments"]["frc"]


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


def measure(note) -> Iterator[Row]:
    all_of_them = np.linspace(CURVE["lowest"], CURVE["highest"], CURVE["frequencies"])
    for name, some in (
        ("low", all_of_them[:16]),
        ("at resonance", all_of_them[9:25]),
        ("high", all_of_them[-16:]),
    ):
        note(f"20 periods of 16 frequencies, {name}")
        seconds = paired(
            {
                "batch": lambda some=some: run(some, 20),
                "one": lambda some=some: [run(one, 20) for one in some[:, None]],
            },
            repeats=3,
        )
        yield Row(
            "sweep",
            f"state-steps per second and core, sixteen {name}",
            16 * 20_000 / seconds["batch"],
            "1/s",
            "one state at a time",
            16 * 20_000 / seconds["one"],
            "higher",
        )
    note("the whole curve on two cores")
    began = time.perf_counter()
    halves = [
        subprocess.Popen([sys.executable, "-m", "benchmarks.sweep", half]) for half in ("0", "1")
    ]
    if any(half.wait() for half in halves):
        raise RuntimeError("half of the curve failed")
    seconds = time.perf_counter() - began
    yield Row(
        "sweep",
        "33 frequencies x 200 periods x 1000 steps on two cores",
        seconds,
        "s",
        "the thesis (another machine)",
        75 * 3600.0,
    )
    yield Row(
        "sweep",
        "state-steps per second on two cores",
        33 * CURVE["periods"] * STEPS_PER_PERIOD / seconds,
        "1/s",
    )


if __name__ == "__main__":
    # Neighbours share their resonance: frequencies that alternate would spread it over both halves.
    every = np.linspace(CURVE["lowest"], CURVE["highest"], CURVE["frequencies"])
    run(every[:16] if sys.argv[1] == "0" else every[16:], CURVE["periods"])
