"""What the full-order steps share: the assembled scene, its integrator, its clock and its bar."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr

from vibrom import effects
from vibrom.artefacts.data import open_dataset, outcome_variables, variable
from vibrom.artefacts.progress import bar
from vibrom.bodies import space
from vibrom.bodies.space import Space
from vibrom.solvers.full.newmark import Motion, Newmark, Record
from vibrom.term import Term


@dataclass(frozen=True)
class FullOrder:
    """A scene ready to run: its space, its term, its Newmark settings and the period [s] of its
    damped first mode.

    `rest` (n,) [m] is its equilibrium under the dead load; displacements that go in and come out
    are measured from it.
    """

    name: str
    space: Space
    term: Term
    newmark: Newmark
    steps_per_period: int
    every: int
    initial_acceleration: str
    frequency: float
    rest: np.ndarray

    @property
    def period(self) -> float:
        return 2 * np.pi / self.frequency

    @property
    def probes(self) -> np.ndarray:
        return np.array(list(self.space.probes.values()), dtype=np.int64)

    def run(
        self,
        displacement: np.ndarray,
        step: np.ndarray,
        steps: int,
        record: Record,
        title: str,
        signal: np.ndarray | None = None,
    ) -> Motion:
        with bar(title, steps * displacement.shape[1], "steps") as advance:
            motion = self.newmark.run(
                self.term,
                self.rest[:, None] + displacement,
                step,
                steps,
                signal=signal,
                initial_acceleration=self.initial_acceleration,
                record=record,
                progress=advance,
            )
        motion.displacement -= self.rest
        motion.probes -= self.rest[record.probes, None]
        return motion

    def forced(
        self, forcing: np.ndarray, frequency: np.ndarray, steps: int, record: Record, title: str
    ) -> Motion:
        """From rest under  p forcing sin(frequency t),  `steps_per_period` steps to each period of
        the forcing.
        """
        phase = 2 * np.pi * np.arange(steps + 1)[:, None] / self.steps_per_period
        step = 2 * np.pi / (frequency * self.steps_per_period)
        return self.run(
            np.zeros((self.space.size, len(forcing))),
            step,
            steps,
            record,
            title,
            np.sin(phase) * forcing,
        )


def build(scene: dict, structure: str) -> FullOrder:
    body = space.build(scene["body"])
    time, known = scene["time"], open_dataset(structure, "structure")
    first = known.isel(mode=0)
    damped = float(first["frequency"]) * np.sqrt(1.0 - float(first["damping_ratio"]) ** 2)
    rest = known["equilibrium"].values if "equilibrium" in known else np.zeros(body.size)
    return FullOrder(
        known.attrs["scene"],
        body,
        effects.assemble(body, scene["effects"]),
        Newmark(alpha=time["alpha"], tolerance=time["residual"]),
        time["steps_per_period"],
        time["every"],
        time["initial_acceleration"],
        damped,
        rest,
    )


def probe_coordinate(model: FullOrder) -> xr.Variable:
    return variable(
        "probe", np.array(list(model.space.probes), dtype=object), "1", "name of the probe"
    )


def motion_outcome(motion: Motion) -> dict[str, xr.Variable]:
    """Outcome variables of a motion of one state."""
    return outcome_variables(motion.outcomes[0], motion.failed_at[0], motion.seconds)
