"""Release state -> train.nc or test.nc: the recorded decay of the full-order model, released at
rest.

Velocity and acceleration are the integrator's, or differences of the displacements as for measured
data (`record.derivatives`). Beside the test decay stands what it would be without errors of the
time integration: from the same first state, without numerical damping, by Richardson's
extrapolation of two steps h and h/2 (`record.finer`):

    q = (4 q_(h/2) - q_h) / 3
"""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from vibrom.artefacts.data import (
    label,
    open_dataset,
    outcome_variables,
    save_dataset,
    variable,
)
from vibrom.artefacts.outcome import Outcome
from vibrom.config.places import FULL_ORDER
from vibrom.config.scene import Record, Time
from vibrom.models.balance import balance_variable, checked
from vibrom.models.full_order import FullOrder
from vibrom.models.measures import nmte_percent
from vibrom.models.model import Watch
from vibrom.models.recorded import differences
from vibrom.solvers.full.newmark import Record as Kept


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
    shape = open_dataset(release, "release")["displacement"].sel(role=role).values
    step, steps = model.period / model.steps_per_period, record.periods * model.steps_per_period
    start = np.concatenate([shape, np.zeros_like(shape)])[None]
    keep = Kept(probes=model.probes)
    motion, balance = model.balanced(start, np.array([step]), steps, keep, None)
    ended = checked(np.array(motion.outcomes, dtype=object), balance, record.balance)
    time, probes = motion.kept * step, motion.probes[0]
    q, v, a = motion.displacement[0], motion.velocity[0], motion.acceleration[0]
    if record.derivatives == "differences":
        v, a = differences(q, step)
        time, q, probes = time[3:-3], q[3:-3], probes[:, 3:-3]
    dims = ("time", "dof")
    kept = slice(None, None, Time.from_builtins(scene["time"]).every)
    dataset = xr.Dataset(
        {
            "displacement": variable(dims, q[kept], "m", "displacement of each free dof"),
            "velocity": variable(dims, v[kept], "m s-1", "velocity of each free dof"),
            "acceleration": variable(dims, a[kept], "m s-2", "acceleration of each free dof"),
            "probe_displacement": variable(
                ("probe", "time"), probes[:, kept], "m", "displacement at the probes"
            ),
            "period": variable((), model.period, "s", "period of the damped first mode"),
            **balance_variable((), balance),
            **outcome_variables(ended[0], motion.failed_at[0], motion.seconds),
        },
        coords={
            "time": variable("time", time[kept], "s", "time since release"),
            "probe": known["probe"].variable,
        },
    )
    if role == "test" and record.finer and Outcome(ended[0]).has_value:
        dataset = dataset.assign(without_errors(model, record.finer, dataset))
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
    save_dataset(dataset, trajectory, provenance)


def without_errors(model: FullOrder, finer: int, own: xr.Dataset) -> dict[str, xr.Variable]:
    """The converged motion beside a recorded one, and the error of that."""
    q, v = own["displacement"].values, own["velocity"].values
    truth = converged(model, finer, np.concatenate([q[0], v[0]]), own["time"].values)
    return {
        "converged_displacement": variable(
            ("time", "dof"), truth, "m", "displacement without errors in time"
        ),
        "converged_nmte": variable(
            (), nmte_percent(truth, q), "percent", "NMTE of the recorded decay against it"
        ),
    }


def converged(model: FullOrder, finer: int, state: np.ndarray, instants: np.ndarray) -> np.ndarray:
    """The displacement (m, n) at these instants (m,) from a state (2n,) at the first of them."""
    watch = Watch(instants - instants[0])
    coarse, fine = (
        model.with_steps(steps * model.steps_per_period).motion(state[None], None, watch)
        for steps in (finer // 2, finer)
    )
    return (4.0 * fine.displacement[0][0] - coarse.displacement[0][0]) / 3.0
