"""A cantilever in space of 30 000 degrees of freedom: statics, modes and time steps.

40 x 15 x 15 trilinear hexahedra. The rival is what a scikit-fem user writes: forms for residual and
tangent, Newton's iteration with SciPy's `splu`, and `eigsh` about zero; its time steps keep their
factor and guess as ours do, and its factors take the best of SciPy's orderings for symmetric
matrices. Both carry their own weight, find the same modes, and take the same steps: released from a
millimetre of the first mode, 200 steps to its period. Each runs in a process of its own, whose peak
of memory is listed.
"""

import json
import subprocess
import sys
import time
from collections.abc import Iterator

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.linalg import eigsh, splu

from benchmarks.growth import peak_memory
from benchmarks.rivals.scikit_fem_newmark import Beam
from benchmarks.table import Row
from vibrom import effects
from vibrom.bodies import space
from vibrom.solvers.full.modes import eigenmodes
from vibrom.solvers.full.newmark import Newmark, Record
from vibrom.solvers.full.static import Body, equilibrium
from vibrom.solvers.full.tangent import PyPardisoSolver

CELLS, MODES, STEPS = (40, 15, 15), 6, 100
CLOSE = 1e-4  # relative: what both find must agree
SIZE = {"length": 1.0, "height": 0.3, "width": 0.28}
EFFECTS = {
    "inertia": {"density": 440.0},
    "elasticity": {"young_modulus": 104.0e9, "poisson_ratio": 0.3},
    "geometric_nonlinearity": {},
}
WEIGHT = {"gravity": {"y": -9.81}}
OURS, RIVAL = "ours", "scikit-fem, splu"
SETTINGS = {"alpha": 0.005, "tolerance": 1e-7, "patience": 3.0}


def body(cells=CELLS):
    """The cantilever."""
    settings = {"shape": "block", **SIZE, "cells": list(cells), "element": "trilinear"}
    return space.build(settings | {"clamped": ["left"], "probes": {}})


def start(shape: np.ndarray, frequency: float) -> tuple[np.ndarray, float]:
    """A millimetre of the first mode [m], and the time step [s]."""
    return 1e-3 * shape / np.abs(shape).max(), 2 * np.pi / frequency / 200


def ours(made) -> Iterator[tuple[str, float, float]]:
    """Each part with its seconds and what it found, by one number."""
    term, loaded = (effects.assemble(made, listed) for listed in (EFFECTS, EFFECTS | WEIGHT))
    Body(loaded).tangent(np.zeros(made.size))  # compiles
    began = time.perf_counter()
    found = equilibrium(loaded)
    yield "statics", time.perf_counter() - began, float(np.linalg.norm(found))
    began = time.perf_counter()
    modes = eigenmodes(term, MODES)
    yield "modes", time.perf_counter() - began, float(modes.frequency[-1])
    q, h = start(modes.shape[0], modes.frequency[0])
    newmark = Newmark(**SETTINGS)

    def run(steps):
        record = Record(start=steps)
        still = {"initial_acceleration": "zero", "record": record}
        return newmark.run(term, q[:, None], np.array([h]), steps, **still)

    run(1)  # compiles
    began = time.perf_counter()
    end = run(STEPS).displacement[0, -1]
    yield "steps", time.perf_counter() - began, float(np.linalg.norm(end))


def theirs(made) -> Iterator[tuple[str, float, float]]:
    """The same of the rival."""
    term, loaded = (effects.assemble(made, listed) for listed in (EFFECTS, EFFECTS | WEIGHT))
    still, load = np.zeros(made.size), loaded.dead_load
    none = csr_matrix(term.mass.shape)
    rival = Beam(made.basis, made.free, term.mass, none, 104.0e9, 0.3, 1.0)
    ordering = {"permc_spec": "MMD_AT_PLUS_A", "options": {"SymmetricMode": True}}
    began, q, residual = time.perf_counter(), still, load
    while np.linalg.norm(residual) > 1e-8 * np.linalg.norm(load):
        q = q + splu(rival.tangent(q).tocsc(), **ordering).solve(residual)
        residual = load - rival.internal(q)
    yield "statics", time.perf_counter() - began, float(np.linalg.norm(q))
    began = time.perf_counter()
    squares, shapes = eigsh(term.stiffness.tocsc(), k=MODES, M=term.mass.tocsc(), sigma=0.0)
    yield "modes", time.perf_counter() - began, float(np.sqrt(squares.max()))
    q, h = start(shapes[:, squares.argmin()], np.sqrt(squares.min()))
    began = time.perf_counter()
    end = rival.run(q, h, STEPS, **SETTINGS, tricks=True)[-1]
    yield "steps", time.perf_counter() - began, float(np.linalg.norm(end))


def one(name: str, cells=CELLS) -> dict[str, tuple[float, float]]:
    """Seconds and finding of each part; the peak of memory [MB] and the number of displacements."""
    made = body(cells)
    parts = {part: found for part, *found in {OURS: ours, RIVAL: theirs}[name](made)}
    return parts | {"memory": [peak_memory(), made.size]}


def apart(name: str) -> dict[str, tuple[float, float]]:
    """`one` in a process of its own."""
    command = [sys.executable, "-m", "benchmarks.solid", name]
    run = subprocess.run(command, stdout=subprocess.PIPE, check=True, text=True)
    return json.loads(run.stdout)


def measure(note) -> Iterator[Row]:
    factors = "PARDISO" if PyPardisoSolver else "LAPACK, as a band"
    note(f"factors by {factors}; the rival takes minutes")
    own, other = apart(OURS), apart(RIVAL)
    text = f"{own['memory'][1]:.0f} dofs in space"
    for part, words in (
        ("statics", "under its weight"),
        ("modes", f"{MODES} modes"),
        ("steps", f"{STEPS} time steps"),
    ):
        (seconds, found), (longer, true) = own[part], other[part]
        if abs(found - true) > CLOSE * abs(true):
            raise ValueError(f"solid: {part}: {found:.9g} is not the rival's {true:.9g}")
        yield Row("solid", f"{text}: {words}", seconds, "s", RIVAL, longer)
    yield Row("solid", f"{text}: memory", own["memory"][0], "MB", RIVAL, other["memory"][0])


if __name__ == "__main__":
    print(json.dumps(one(sys.argv[1])))
