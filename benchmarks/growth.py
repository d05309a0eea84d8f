"""Growth from 240 to 60 000 degrees of freedom.

Longer bodies have the same band, finer ones a wider band; both elements. Each body starts straight
with a wavy velocity, as long as the first metre (or as the plate or cube), which takes the same
Newton iterations at any size: one state, 1000 steps to the period of the 1 m beam (or of the plate
or cube). A body whose band is wider than `newmark.WIDEST` is factorised as a sparse matrix, by
PARDISO where it is installed, else by LAPACK as a band of its own or, where that is too wide, by
SuperLU (`factors`); square plates and cubes on both sides of that bound are timed both ways. Each
body runs in a process of its own, whose peak of memory, less that of the smallest body, is listed.
The exponent is that of a power law fitted to the bodies above 1000 degrees of freedom.
"""

import json
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd

from benchmarks.cantilever import NEWMARK, STEPS_PER_PERIOD, build
from benchmarks.table import Row
from vibrom.solvers.full.newmark import Record
from vibrom.solvers.full.tangent import PyPardisoSolver

WIDEST = None  # as `Newmark` chooses
TIME, MEMORY = "time per step", "memory beyond the smallest"
# family -> element, and (cells, length [m], widest band) of its bodies
FAMILIES = {
    "longer, bilinear": ("bilinear", [((40 * k, 2), 1.0 * k, WIDEST) for k in (1, 4, 16, 64, 250)]),
    "longer, quadratic": ("quadratic", [((40 * k, 2), 1.0 * k, WIDEST) for k in (1, 4, 16, 64)]),
    "finer, bilinear": ("bilinear", [((40 * k, 2 * k), 1.0, WIDEST) for k in (1, 2, 4, 8, 13)]),
    "finer, quadratic": ("quadratic", [((20 * k, k), 1.0, WIDEST) for k in (1, 2, 4, 8, 18)]),
    "a square plate, in the band": (
        "bilinear",
        [((k, k), "square", 10**6) for k in (20, 40, 80, 120, 170)],
    ),
    "a square plate, sparse": ("bilinear", [((k, k), "square", 0) for k in (20, 40, 80, 120, 170)]),
    "a cube, in the band": ("trilinear", [((k,) * 3, "square", 10**6) for k in (4, 7, 10, 13, 16)]),
    "a cube, sparse": ("trilinear", [((k,) * 3, "square", 0) for k in (4, 7, 10, 13, 16)]),
}


def one(element: str, cells: tuple[int, ...], length: float | str, widest: int | None) -> dict:
    square = length == "square"
    size, wave = (0.02, 0.02) if square else (length, 1.0)
    model = build(("modal_load",), element=element, cells=tuple(cells), length=size)
    x, along_y = model.space.dof_location[:, 0], model.space.dof_axis == 1
    frequency = (model if square else build(("modal_load",))).frequency
    thrown = (0.02 * wave * frequency * (1 - np.cos(2 * np.pi * x / wave)) * along_y)[:, None]
    newmark, step = (
        replace(NEWMARK, widest_band=widest),
        np.array([2 * np.pi / frequency / STEPS_PER_PERIOD]),
    )

    def run(steps: int):
        return newmark.run(
            model.term,
            np.zeros_like(thrown),
            step,
            steps,
            velocity=thrown,
            initial_acceleration="zero",
            record=Record(start=steps + 1),
        )

    steps = 5
    motion = run(steps)  # compiles, and warms up
    while (motion := run(steps)).seconds < 0.5:
        steps = int(steps * min(10.0, 0.8 / motion.seconds)) + 1
    assert motion.outcomes == ["ok"]
    return {
        "dofs": model.space.size,
        "seconds": motion.seconds / steps,
        "memory": peak_memory(),
        "factors": motion.factorisations / steps,
    }


def peak_memory() -> float:
    """MB that this program has held at most; what `getrusage` tells would include its parent's."""
    (line,) = [
        line
        for line in Path("/proc/self/status").read_text().splitlines()
        if line.startswith("VmHWM")
    ]
    return int(line.split()[1]) / 1024


def apart(*body) -> dict:
    """`one` in a process of its own."""
    run = subprocess.run(
        [sys.executable, "-m", "benchmarks.growth", json.dumps(body)],
        stdout=subprocess.PIPE,
        check=True,
        text=True,
    )
    return json.loads(run.stdout)


def measure(note) -> Iterator[Row]:
    note(f"sparse factors by {'PARDISO' if PyPardisoSolver else 'SuperLU'}")
    for family, (element, bodies) in FAMILIES.items():
        apart(element, *bodies[0])  # compiles, and a compiler holds more memory than a small body
        found = []
        for body in bodies:
            found.append(apart(element, *body))
            dofs = found[-1]["dofs"]
            found[-1]["more"] = found[-1]["memory"] - found[0]["memory"]
            for panel, value, unit in (
                (TIME, 1e3 * found[-1]["seconds"], "ms"),
                (MEMORY, found[-1]["more"], "MB"),
            ):
                text = f"{panel}, {family}, {dofs} dofs"
                yield Row("growth", text, value, unit, panel=panel, series=family, at=dofs)
        large = [body for body in found if body["dofs"] > 1000]
        for panel, name in ((TIME, "seconds"), ("memory", "more")):
            values = np.maximum([body[name] for body in large], 1e-9)
            power = np.polyfit(np.log([body["dofs"] for body in large]), np.log(values), 1)[0]
            yield Row("growth", f"exponent of {panel}, {family}", power, "1")


def figures(rows: pd.DataFrame) -> dict:
    figure, axes = plt.subplots(1, 2, figsize=(7.2, 2.8))
    for axis, panel, label in zip(axes, (TIME, MEMORY), ("time per step [ms]", "memory [MB]")):
        some = rows[(rows["panel"] == panel) & (rows["value"] > 0)]
        for number, (family, group) in enumerate(some.groupby("series", sort=False)):
            style = {"marker": "os^Dv<Ph"[number], "markersize": 3.5, "label": family}
            axis.loglog(group["at"].astype(int), group["value"], **style)
        axis.set(xlabel="degrees of freedom", ylabel=label)
    axes[0].legend()
    return {"growth": figure}


if __name__ == "__main__":
    print(json.dumps(one(*json.loads(sys.argv[1]))))
