"""The full-order model: a body with its effects, integrated in time.

Runs take `steps_per_period` steps to each period of their drive, or of the damped first mode where
they are left alone; instants that are watched lie on those steps.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from vibrom import effects
from vibrom.artefacts.progress import bar
from vibrom.bodies import space
from vibrom.config.scene import Time
from vibrom.models.balance import Ledger
from vibrom.models.model import Drive, Motion, Push, Watch
from vibrom.models.recorded import damped_frequency
from vibrom.models.scratch import room
from vibrom.models.training import Unsupported
from vibrom.solvers.full.batch import Further
from vibrom.solvers.full.newmark import Motion as SolverMotion
from vibrom.solvers.full.newmark import Newmark, Record
from vibrom.term import Term

if TYPE_CHECKING:
    from vibrom.solvers.periodic.newmark_map import NewmarkMap

CLOSE = 1e-9  # relative residual; rounding allows no less
ON_STEP = 1e-6  # of a step: farther from one an instant is not on the grid


@dataclass(frozen=True)
class FullOrder:
    """A scene ready to run."""

    term: Term
    probes: np.ndarray  # (k,) free displacement that each probe watches
    newmark: Newmark
    steps_per_period: int
    initial_acceleration: str  # zero, or that of equilibrium with the forces at the start
    frequency: float  # rad/s, damped first frequency
    poles: np.ndarray  # complex, 1/s, of small motions about the rest state
    rest: np.ndarray  # (n,) m, equilibrium under the dead load
    title: str = "full order"  # for the progress bar
    # Where each displacement is (n, dim) [m] and along which axis (n,), where that is known: a body
    # that is its own mirror image has motions that half a period decides.
    place: np.ndarray | None = None
    axis: np.ndarray | None = None

    @classmethod
    def of_scene(cls, scene: dict[str, Any], known: xr.Dataset) -> FullOrder:
        """The model of a scene with the blocks `body`, `effects` and `time`; `known` is its
        structure.
        """
        body, time = space.build(scene["body"]), Time.from_builtins(scene["time"])
        omega, zeta = known["frequency"].values, known["damping_ratio"].values
        root = np.sqrt(zeta.astype(complex) ** 2 - 1.0)
        return cls(
            term=effects.assemble(body, scene["effects"]),
            probes=known["probe_dof"].values,
            newmark=Newmark(time.alpha, time.scheme, time.residual, time.iterations),
            steps_per_period=time.steps_per_period,
            initial_acceleration=time.initial_acceleration,
            frequency=damped_frequency(known),
            poles=np.concatenate([omega * (-zeta + root), omega * (-zeta - root)]),
            rest=known["equilibrium"].values if "equilibrium" in known else np.zeros(body.size),
            title=str(known.attrs["scene"]),
            place=body.dof_location,
            axis=body.dof_axis,
        )

    @property
    def size(self) -> int:
        """n, free displacements."""
        return len(self.rest)

    @property
    def samples(self) -> int:
        """Instants of a period that cost nothing extra: the steps."""
        return self.steps_per_period

    @property
    def period(self) -> float:
        """Of the damped first mode [s]."""
        return 2.0 * np.pi / self.frequency

    def coordinates(self, state: np.ndarray) -> np.ndarray:
        """The state (m, 2n) itself."""
        return state

    def decoded(self, coordinates: np.ndarray, dofs: np.ndarray | None = None) -> np.ndarray:
        """The displacements of a state."""
        displacement = coordinates[..., : self.size]
        return displacement if dofs is None else displacement[..., dofs]

    def eigenvalues(self) -> np.ndarray:
        """Omega (-zeta +- sqrt(zeta^2 - 1)) of its modes [1/s]."""
        return self.poles

    def return_map(self) -> NewmarkMap:
        """See `Model.return_map`."""
        from vibrom.solvers.periodic.newmark_map import NewmarkMap
        from vibrom.solvers.periodic.symmetry import candidates, holds

        if self.newmark.scheme != "newmark":
            raise Unsupported(
                f"time.scheme = {self.newmark.scheme}: the derivative of its steps is not known, "
                "and periodic motions are not followed without it; choose newmark"
            )
        mirrors = candidates(self.place, self.axis, self.size)
        return NewmarkMap(
            term=self.term,
            newmark=self.newmark,
            steps_per_period=self.steps_per_period,
            frequency=self.frequency,
            probes=self.probes,
            rest=self.rest,
            symmetry=next((mirror for mirror in mirrors if holds(mirror, self.term)), None),
        )

    def with_steps(self, steps: int) -> FullOrder:
        """The model without numerical damping, closely solved and started in balance, with so many
        steps to a period.
        """
        newmark = Newmark(alpha=0.0, tolerance=CLOSE)
        return replace(
            self, newmark=newmark, steps_per_period=steps, initial_acceleration="equilibrium"
        )

    def motion(self, start: np.ndarray, drive: Push, *watches: Watch) -> Motion:
        """See `Model.motion`. Raises ValueError where an instant does not lie on a step."""
        runs = len(start)
        period = drive.period if isinstance(drive, Drive) else np.full(runs, self.period)
        step = period / self.steps_per_period
        places = [steps_of(watch.instants, step) for watch in watches]
        last = max(int(place[-1]) for place in places)
        record = _record(watches, places, last)
        scratch = room(runs, record.count(last), self.size, self.rest)
        run, balance = self.balanced(start, step, last, replace(record, sink=scratch), drive)
        whole = run.displacement if scratch is None else scratch.variable
        displacement = tuple(
            whole[:, np.searchsorted(run.kept, place)]
            if watch.dofs is None
            else run.probes[:, np.searchsorted(record.probes, watch.dofs)][
                :, :, place - record.probe_start
            ].transpose(0, 2, 1)
            for watch, place in zip(watches, places)
        )
        outcome = np.array(run.outcomes, dtype=object)
        unknown = np.full(runs, np.nan)
        return Motion(displacement, None, outcome, run.failed_at, unknown, balance, run.seconds)

    def balanced(
        self, start: np.ndarray, step: np.ndarray, steps: int, record: Record, drive: Push
    ) -> tuple[SolverMotion, np.ndarray]:
        """`run`, and its work balance (b,)."""
        ledger = Ledger(self.term, self.rest, step, self.steps_per_period, drive)
        run = self.run(start, step, steps, replace(record, observer=ledger), drive)
        return run, np.where(np.isnan(run.failed_at), ledger.balance(), np.nan)

    def run(
        self, start: np.ndarray, step: np.ndarray, steps: int, record: Record, drive: Push
    ) -> SolverMotion:
        """`steps` steps of `step` (b,) [s] from `start` (b, 2n), with all that the integrator
        keeps. Loads with signals of their own act in steps of one length.
        """
        displacement, velocity = (part.T for part in np.split(start, 2, axis=1))
        term, signal, more = self.term, None, None
        if isinstance(drive, Drive):
            phase = 2.0 * np.pi * np.arange(steps + 1)[:, None] / self.steps_per_period
            signal = np.sin(phase) * drive.amplitude
        elif drive is not None:
            values = drive.value(step[0] * np.arange(steps + 1)).transpose(1, 2, 0)
            term, signal = replace(term, load=drive.load[0]), values[0]
            more = Further(drive.load[1:], values[1:]) if len(drive.load) > 1 else None
        with bar(self.title, steps * len(start), "steps") as advance:
            motion = self.newmark.run(
                term,
                self.rest[:, None] + displacement,
                step,
                steps,
                velocity=velocity,
                signal=signal,
                more=more,
                initial_acceleration=self.initial_acceleration,
                record=record,
                progress=advance,
            )
        motion.displacement -= self.rest
        motion.probes -= self.rest[record.probes, None]
        return motion


def steps_of(instants: np.ndarray, step: np.ndarray) -> np.ndarray:
    """Step numbers (m,) of `instants` (m,) or (b, m) [s] for steps (b,) [s]."""
    exact = np.broadcast_to(instants, (len(step), np.shape(instants)[-1])) / step[:, None]
    place = np.rint(exact[0]).astype(np.int64)
    off = np.abs(exact - place)
    if off.size and off.max() > ON_STEP:
        at = np.unravel_index(off.argmax(), off.shape)
        raise ValueError(
            f"the instant {np.broadcast_to(instants, exact.shape)[at]:.9g} s lies between two time "
            f"steps of {step[at[0]]:.9g} s; watch instants that are whole steps"
        )
    return place


def _record(watches: tuple[Watch, ...], places: list[np.ndarray], last: int) -> Record:
    """What the integrator must keep to answer these watches."""
    whole = [place for watch, place in zip(watches, places) if watch.dofs is None]
    some = [(watch.dofs, place) for watch, place in zip(watches, places) if watch.dofs is not None]
    start, every = last + 1, 1
    if whole:
        wanted = np.unique(np.concatenate(whole))
        start, every = int(wanted[0]), max(int(np.gcd.reduce(np.diff(wanted))), 1)
    if not some:
        return Record(every=every, start=start)
    probes = np.unique(np.concatenate([dofs for dofs, _ in some]))
    probe_start = min(int(place[0]) for _, place in some)
    return Record(every=every, start=start, probes=probes, probe_start=probe_start)
