"""Response curves with all their branches: seconds of a point and of a whole curve.

A point of the full order is a periodic motion with all its Floquet multipliers, at the folding
scene's forcing and time steps. Its derivative is carried along the steps by the factors that each
step has; the rival takes differences, 480 neighbours side by side, in the same coordinates. The
whole curve goes from 0.8 to 1.2 times the first frequency, through both folds; so do those of the
run's fitted models, on one core, of which some leave their training range or end early.
"""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

from benchmarks.cantilever import SCENE, STEPS_PER_PERIOD
from benchmarks.table import Row, paired
from vibrom.artefacts.data import open_dataset
from vibrom.experiments import Given
from vibrom.experiments.branches import Branches
from vibrom.models.curves import curve_of
from vibrom.models.full_order import FullOrder
from vibrom.models.reduced import Reduced
from vibrom.models.rollout import Integrator
from vibrom.models.rom import rom_from_dataset
from vibrom.solvers.full.newmark import Record
from vibrom.solvers.periodic.newmark_map import NewmarkMap

RESULTS = Path("results/folding")
QUESTION = Branches(**SCENE["experiments"]["branches"])
OFF, NUDGE, CORES = 0.95, 1e-6, 2  # times the first frequency; of the size of the motion


@contextmanager
def threads(count: int):
    """Columns are carried on so many."""
    before = os.environ.get("OMP_NUM_THREADS", "1")
    os.environ["OMP_NUM_THREADS"] = str(count)
    yield
    os.environ["OMP_NUM_THREADS"] = before


def by_differences(flow: NewmarkMap, x: np.ndarray, frequency: float) -> np.ndarray:
    """The derivative (2n, 2n), one column a neighbour."""
    step = NUDGE * np.linalg.norm(x)
    points = x + step * np.vstack([np.zeros_like(x), np.eye(len(x))])
    states = np.stack([flow.state(point) for point in points], axis=1)
    drive = np.full(len(points), frequency), np.full(len(points), QUESTION.forcing)
    motion = flow._motion(states, *drive, Record(start=STEPS_PER_PERIOD // flow.parts))
    ends = np.concatenate([motion.displacement[:, 0] - flow.rest, motion.velocity[:, 0]], axis=1)
    ends = np.stack([flow.of_state(flow._turned(end)) for end in ends])
    return (ends[1:] - ends[0]).T / step


def measure(note) -> Iterator[Row]:
    fitted = sorted(RESULTS.glob("*/*/rom.nc"))
    if not fitted:
        note(f"{RESULTS} holds no models: run make first")
        return
    known = open_dataset(str(RESULTS / "full_order/structure.nc"), "structure")
    given = Given(known, 1, {})
    scene = {name: SCENE[name] for name in ("body", "effects", "time")}
    model = FullOrder.of_scene(scene | {"body": {"shape": "rectangle"} | scene["body"]}, known)
    flow, frequency = model.return_map(), OFF * model.frequency
    x = flow.after(np.zeros(flow.size), frequency, QUESTION.forcing, 30)
    note("a point")
    with threads(CORES), threadpool_limits(1, "blas"):
        ours = paired({"ours": lambda: flow(x, frequency, QUESTION.forcing).multipliers})
        rival = paired({"rival": lambda: by_differences(flow, x, frequency)}, 1, warm_up=False)
        what = f"derivative and all multipliers of a motion, {CORES} cores"
        named = "differences, neighbours side by side"
        yield Row("branches", what, ours["ours"], "s", named, rival["rival"])
        note("the full order's curve, a minute or two")
        answer = QUESTION.ask(model, given)
    count, whole = answer.sizes["point"], float(answer["seconds"])
    yield Row("branches", f"full order, {count} motions, {CORES} cores", whole, "s")
    yield Row("branches", "full order, a motion", whole / count, "s")
    for path in fitted:
        method, seed = path.parts[-3:-1]
        rom = rom_from_dataset(open_dataset(str(path), "rom"))
        reduced = Reduced.of_scene(rom, known, Integrator())
        note(f"{method} {seed}")
        seconds = paired({"curve": lambda reduced=reduced: QUESTION.ask(reduced, given)}, 3)
        answer = QUESTION.ask(reduced, given)
        folds = len(curve_of(answer).folds)
        words = f"{method} {seed}, {answer.sizes['point']} motions, {folds} folds"
        yield Row("branches", words, seconds["curve"], "s")
