"""Release state -> train.nc or test.nc: the recorded decay of the full-order model.

Velocity and acceleration are the integrator's, or differences of the displacements as for measured
data (`record.derivatives`). Beside the test decay stands what it would be without errors of the
time integration: from the same first state, without numerical damping, by Richardson's
extrapolation of two steps h and h/2 (`record.finer`):

    q = (4 q_(h/2) - q_h) / 3

All of them go to the file as they come: a decay needs not fit into memory.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import xarray as xr

from vibrom.artefacts.data import label, open_dataset, outcome_variables, variable
from vibrom.artefacts.outcome import Outcome
from vibrom.artefacts.stream import Growing, growing
from vibrom.config.places import FULL_ORDER
from vibrom.config.scene import Record, Time
from vibrom.models.balance import balance_variable, checked
from vibrom.models.full_order import FullOrder
from vibrom.models.recorded import STENCIL, differences, released
from vibrom.solvers.full.newmark import Record as Kept

BESIDE = "converged_displacement"


def run(
    *,
    structure: str,
    release: str,
    trajectory: str,
    scene: dict[str, Any],
    role: str,
    provenance: dict[str, str],
) -> None:
    """`scene` has the blocks `body`, `effects`, `record` and `time`."""
    known = open_dataset(structure, "structure")
    model, record = FullOrder.of_scene(scene, known), Record.from_builtins(scene["record"])
    steps, every = record.periods * model.steps_per_period, Time.from_builtins(scene["time"]).every
    lost = STENCIL // 2 if record.derivatives == "differences" else 0
    kept = np.arange(lost, steps + 1 - lost, every)
    sizes, finer = {"time": len(kept), "dof": model.size}, record.finer if role == "test" else 0
    with growing(trajectory, sizes, record.stored, 4 if finer else 3) as file:
        step = model.period / model.steps_per_period
        rows = Rows(file, model.rest, step, every, lost)
        keep = Kept(every=1 if lost else every, probes=model.probes, sink=rows)
        start = released(open_dataset(release, "release"), role)[None]
        motion, balance = model.balanced(start, np.array([step]), steps, keep, None)
        ended = checked(np.array(motion.outcomes, dtype=object), balance, record.balance)
        probes = motion.probes[0][:, kept]
        dataset = xr.Dataset(
            {
                "probe_displacement": variable(
                    ("probe", "time"), probes, "m", "displacement at the probes"
                ),
                "period": variable((), model.period, "s", "period of the damped first mode"),
                **balance_variable((), balance),
                **outcome_variables(ended[0], motion.failed_at[0], motion.seconds),
            },
            coords={
                "time": variable("time", kept * step, "s", "time since release"),
                "probe": known["probe"].variable,
            },
        )
        if finer and Outcome(ended[0]).has_value:
            dataset = dataset.assign(converged_nmte=converged(model, finer, every, len(kept), file))
        dataset = label(
            dataset,
            "trajectory",
            scene=str(known.attrs["scene"]),
            method=FULL_ORDER,
            role=role,
            derivatives=record.derivatives,
            iterations=motion.iterations,
            factorisations=motion.factorisations,
        )
        file.finish(dataset, provenance)


@dataclass
class Rows:
    """To the file, every so many steps: displacement, velocity and acceleration, where steps are
    `lost` at both ends by differences of the displacements of all of them.
    """

    file: Growing
    rest: np.ndarray  # (n,) m
    step: float  # s
    every: int
    lost: int  # 0: velocity and acceleration are the integrator's
    before: np.ndarray = field(init=False)  # (up to 2 lost, n) m, of the last steps
    done: int = 0  # rows

    def __post_init__(self) -> None:
        self.before = np.zeros((0, len(self.rest)))
        self.file.add("displacement", "m", "displacement of each free dof")
        self.file.add("velocity", "m s-1", "velocity of each free dof")
        self.file.add("acceleration", "m s-2", "acceleration of each free dof")

    def see(
        self, steps: np.ndarray, where: slice, q: np.ndarray, v: np.ndarray, a: np.ndarray
    ) -> None:
        """See `Sink`."""
        rows = [q[:, :, 0] - self.rest, v[:, :, 0], a[:, :, 0]]
        if self.lost and len(steps):
            first = int(steps[0]) - len(self.before)
            whole = np.concatenate([self.before, rows[0]])
            self.before = whole[-2 * self.lost :].copy()
            if len(whole) <= 2 * self.lost:
                return
            some = slice(-first % self.every, None, self.every)
            rows = [whole[self.lost : -self.lost][some], *differences(whole, self.step, some)]
        for name, values in zip(("displacement", "velocity", "acceleration"), rows):
            self.file.write(name, self.done, values)
        self.done += len(rows[0])


@dataclass
class Beside:
    """To the file, displacements at h, then (4 q - that)/3 with those at h/2; and how far from the
    recorded ones these are.
    """

    file: Growing
    rest: np.ndarray  # (n,) m
    fine: bool = False
    done: int = 0  # rows
    sizes: list[np.ndarray] = field(default_factory=list)  # m, norms
    errors: list[np.ndarray] = field(default_factory=list)  # m, norms

    def see(
        self, steps: np.ndarray, where: slice, q: np.ndarray, v: np.ndarray, a: np.ndarray
    ) -> None:
        """See `Sink`."""
        rows = q[:, :, 0] - self.rest
        if self.fine:
            rows = (4.0 * rows - self.file.read(BESIDE, self.done, len(rows))) / 3.0
            own = self.file.read("displacement", self.done, len(rows))
            self.sizes.append(np.linalg.norm(rows, axis=-1))
            self.errors.append(np.linalg.norm(rows - own, axis=-1))
        self.file.write(BESIDE, self.done, rows)
        self.done += len(rows)


def converged(model: FullOrder, finer: int, every: int, count: int, file: Growing) -> xr.Variable:
    """The NMTE of a recorded motion against the converged one, which goes to the file beside it."""
    file.add(BESIDE, "m", "displacement without errors in time")
    start = np.concatenate([file.read(name, 0, 1)[0] for name in ("displacement", "velocity")])
    for part in (finer // 2, finer):
        other = model.with_steps(part * model.steps_per_period)
        beside = Beside(file, model.rest, fine=part == finer)
        keep, steps = Kept(every=part * every, sink=beside), (count - 1) * part * every
        other.run(start[None], np.array([other.period / other.steps_per_period]), steps, keep, None)
    sizes, errors = np.concatenate(beside.sizes), np.concatenate(beside.errors)
    words = "NMTE of the recorded decay against it"
    return variable((), 100.0 * errors.mean() / sizes.max(), "percent", words)
