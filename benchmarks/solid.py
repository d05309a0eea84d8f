"""A cantilever in space of 27 000 degrees of freedom: statics, modes and time steps.

40 x 14 x 14 trilinear hexahedra. The rival is what a scikit-fem user writes: forms for residual and
tangent, SciPy's `splu` as it is, and `eigsh` about zero; one Newton iteration of it stands for
statics and for a time step, which take one at least. Each runs in a process of its own, whose peak
of memory is listed. The motion is released from a millimetre of the first mode, 200 steps to its
period.
"""

import json
import subprocess
import sys
import time
from collections.abc import Iterator

import numpy as np
from scipy.sparse.linalg import eigsh, splu

from benchmarks.growth import peak_memory
from benchmarks.rivals.scikit_fem_newmark import Beam
from benchmarks.table import Row
from vibrom import effects
from vibrom.bodies import space
from vibrom.solvers.full.modes import eigenmodes
from vibrom.solvers.full.newmark import Newmark, Record
from vibrom.solvers.full.static import Body

CELLS, MODES, STEPS = (40, 14, 14), 6, 100
SIZE = {"length": 1.0, "height": 0.3, "width": 0.3}
EFFECTS = {
    "inertia": {"density": 440.0},
    "elasticity": {"young_modulus": 104.0e9, "poisson_ratio": 0.3},
    "geometric_nonlinearity": {},
    "gravity": {"y": -9.81},
}


def one(name: str) -> dict[str, float]:
    """Seconds of each part, and the peak of memory [MB]."""
    body = space.build(
        {
            "shape": "block",
            **SIZE,
            "cells": list(CELLS),
            "element": "trilinear",
            "clamped": ["left"],
            "probes": {},
        }
    )
    term, seconds = effects.assemble(body, EFFECTS), {"dofs": float(body.size)}
    load, still = term.dead_load, np.zeros(body.size)

    def clock(part, call):
        began = time.perf_counter()
        found = call()
        seconds[part] = time.perf_counter() - began
        return found

    if name == "ours":
        model = Body(term)
        model.tangent(still)  # compiles
        clock("iteration", lambda: model.factor(still).solve(load - model.internal(still)))
        first = clock("modes", lambda: eigenmodes(term, MODES))
        start = 1e-3 * first.shape[0] / np.abs(first.shape[0]).max()
        h = np.array([2 * np.pi / first.frequency[0] / 200])

        def run(steps):
            return Newmark(alpha=0.005).run(
                term, start[:, None], h, steps, record=Record(start=steps + 1)
            )

        run(1)
        motion = clock("steps", lambda: run(STEPS))
        seconds["factors"] = float(motion.factorisations)
    else:
        rival = Beam(body.basis, body.free, term.mass, None, 104.0e9, 0.3, 1.0)

        def iterate():
            return splu(rival.tangent(still).tocsc()).solve(load - rival.internal(still))

        clock("iteration", iterate)
        stiffness, mass = term.stiffness.tocsc(), term.mass.tocsc()
        clock("modes", lambda: eigsh(stiffness, k=MODES, M=mass, sigma=0.0))
    return seconds | {"memory": peak_memory()}


def apart(name: str) -> dict[str, float]:
    """`one` in a process of its own."""
    command = [sys.executable, "-m", "benchmarks.solid", name]
    run = subprocess.run(command, stdout=subprocess.PIPE, check=True, text=True)
    return json.loads(run.stdout)


def measure(note) -> Iterator[Row]:
    note("27 000 degrees of freedom; the rival takes minutes")
    ours, theirs = apart("ours"), apart("scikit-fem")
    text = f"{ours['dofs']:.0f} dofs in space"
    rival = "scikit-fem, splu"
    for part, words in (
        ("iteration", "a Newton iteration of statics"),
        ("modes", f"{MODES} modes"),
    ):
        yield Row("solid", f"{text}: {words}", ours[part], "s", rival, theirs[part])
    step = ours["steps"] / STEPS
    yield Row("solid", f"{text}: a time step", step, "s", "one iteration", theirs["iteration"])
    yield Row("solid", f"{text}: factorisations of {STEPS} steps", ours["factors"], "1")
    yield Row("solid", f"{text}: memory", ours["memory"], "MB", rival, theirs["memory"])


if __name__ == "__main__":
    print(json.dumps(one(sys.argv[1])))
