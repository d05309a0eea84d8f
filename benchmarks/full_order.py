"""Full-order time steps against scikit-fem and SciPy.

Rival A is what a user writes today: Newmark's method with scikit-fem forms, Newton's iteration and
SciPy's sparse LU (`benchmarks/rivals/scikit_fem_newmark.py`). Mesh, step and tolerance are the
same, and so are the displacements, to the tolerance of the iteration. A second version of the rival
has our first guess and our rule for keeping a factor, so that the difference between the two is
compiled kernels and the band. The motion is the folding decay, from its release on.
"""

from collections.abc import Iterator

import numpy as np

from benchmarks.cantilever import NEWMARK, SCENE, build, released
from benchmarks.rivals.scikit_fem_newmark import Beam
from benchmarks.table import Row, paired
from vibrom.solvers.full.newmark import Record

STEPS, RIVAL_STEPS = 5000, 50


def measure(note) -> Iterator[Row]:
    model, q0 = build(), released()
    elasticity = SCENE["effects"]["elasticity"]
    rival = Beam(
        model.space.basis,
        model.space.free,
        model.term.mass,
        model.term.damping,
        elasticity["young_modulus"],
        elasticity["poisson_ratio"],
        model.space.thickness,
    )

    def ours(steps: int = STEPS) -> np.ndarray:
        return NEWMARK.run(
            model.term,
            q0[:, None],
            np.array([model.step]),
            steps,
            initial_acceleration="zero",
            record=Record(every=10),
        ).displacement[0]

    def theirs(tricks: bool = False) -> np.ndarray:
        return rival.run(
            q0,
            model.step,
            RIVAL_STEPS,
            alpha=NEWMARK.alpha,
            tolerance=NEWMARK.tolerance,
            patience=NEWMARK.patience,
            tricks=tricks,
        )

    note(f"{STEPS} steps, the rival {RIVAL_STEPS}")
    mine, other = ours(RIVAL_STEPS), theirs()[::10]
    apart = np.linalg.norm(mine - other) / np.linalg.norm(other - q0)
    seconds = paired(
        {"ours": ours, "rival": theirs, "clever": lambda: theirs(tricks=True)}, repeats=5
    )
    for name, text in (
        ("rival", "scikit-fem and splu"),
        ("clever", "the same with our guess and kept factors"),
    ):
        yield Row(
            "full_order",
            "steps per second, one state",
            STEPS / seconds["ours"],
            "1/s",
            text,
            RIVAL_STEPS / seconds[name],
            "higher",
        )
    yield Row(
        "full_order",
        f"difference between both after {RIVAL_STEPS} steps, over the distance moved",
        apart,
        "1",
    )
    yield Row(
        "full_order",
        "a decay of 30 periods",
        30_000 / STEPS * seconds["ours"],
        "s",
        "the thesis (another machine)",
        1228.0,
    )
