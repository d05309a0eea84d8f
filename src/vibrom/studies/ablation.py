"""What each effect of a scene is worth, shown by leaving it out.

The whole scene, and the scene without one effect at a time, are evaluated alike: first frequency; a
decay from the test release; a forced run from rest; seconds a step. Instants, frequency and
amplitude of the forcing are those of the whole scene, and all bodies are released from the same
place in space. Decays are compared by where a body goes, seen from the rest state of the whole
scene; amplitudes are measured from the rest state of each. An effect that another one needs cannot
be left out alone; without mass everywhere only the static response is left. From there the study
goes on to sets of effects, and advises which ones the scene can do without (`parts.advice`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from statistics import median
from typing import Any

import numpy as np
import xarray as xr

from vibrom import effects
from vibrom.artefacts.data import variable
from vibrom.artefacts.outcome import Outcome
from vibrom.bodies import space
from vibrom.config.kinds import Count, Tolerance
from vibrom.config.plugs import in_order
from vibrom.models.full_order import FullOrder
from vibrom.models.measures import crossings, nmte_percent
from vibrom.models.model import Drive
from vibrom.models.recorded import released
from vibrom.models.scratch import room
from vibrom.solvers.full import static
from vibrom.solvers.full.modes import eigenmodes, linearised
from vibrom.solvers.full.newmark import Motion, Record
from vibrom.studies import Case, Study
from vibrom.studies.parts.advice import advise, variables
from vibrom.studies.parts.records import Column, stacked, text
from vibrom.term import SceneError, Term

LENGTHS = ("decay_periods", "forced_periods", "timed_periods", "repeats")
WHOLE = "nothing"  # the effect that the whole scene leaves out
LEFT_OUT, PROBE = "left_out", ("probe",)
COLUMNS = {
    "outcome": Column("1", "how it ended", missing=Outcome.NOT_RUN),
    "needed_by": Column("1", "effects that cannot do without it", missing=""),
    "failed_at": Column("s", "simulated time at which a run failed"),
    "first_frequency": Column("rad s-1", "undamped first angular frequency about the rest state"),
    "decay_nmte": Column(
        "percent", "normalised mean-trajectory error of the decay against the whole scene's"
    ),
    "decay_frequency": Column("rad s-1", "mean angular frequency of the decay", PROBE),
    "decay_amplitude": Column(
        "m", "largest displacement from rest in the last period of the decay", PROBE
    ),
    "decay_displacement": Column("m", "decay at the probes", ("probe", "time")),
    "forced_amplitude": Column(
        "m", "largest displacement in the last period of the forced run, or the static one", PROBE
    ),
    "forced_displacement": Column(
        "m", "last period of the forced run at the probes", ("probe", "last_time")
    ),
    "iterations_per_step": Column("1", "Newton iterations a step of the decay"),
    "seconds_per_step": Column(
        "s",
        "wall time of a step of the decay's first periods, median of runs that take turns; loading "
        "and compilation excluded",
    ),
    "seconds_ratio": Column(
        "1",
        "wall time of the whole scene's step over that of one without the effect: median over the "
        "turns",
    ),
}


@dataclass(frozen=True)
class Runs:
    """What every body is evaluated on: the whole scene's instants, release and forcing."""

    whole: FullOrder
    release: np.ndarray  # (2n,) m, from the undeformed body, and m/s
    forcing: float  # amplitude, times the scene's load
    every: int  # store every n-th step
    decay_steps: int
    forced_steps: int

    @property
    def step(self) -> float:
        """Of the time integration [s]."""
        return self.whole.period / self.whole.steps_per_period

    def decay(self, body: FullOrder, steps: int, record: Record) -> Motion:
        """A body, about its own rest state, that is released."""
        start = self.release - np.concatenate([body.rest, np.zeros(body.size)])
        return body.run(start[None], np.array([self.step]), steps, record, None)

    def forced(self, body: FullOrder) -> Motion:
        """The last period of a body that is driven from rest."""
        record = Record(
            start=self.forced_steps + 1,
            probes=body.probes,
            probe_start=self.forced_steps - body.steps_per_period,
        )
        drive = Drive(np.array([self.forcing]), np.array([self.whole.frequency]))
        step, start = np.array([self.step]), np.zeros((1, 2 * body.size))
        return body.run(start, step, self.forced_steps, record, drive)


@dataclass(frozen=True)
class Ablation(Study):
    """How long the runs are."""

    decay_periods: Count  # of the damped first mode
    forced_periods: Count  # the response is that of the last one
    timed_periods: Count  # of a decay whose time is taken
    repeats: Count  # runs of each body, of which the median is the time
    tolerance: Tolerance = 0.05  # of the advice: what left-out effects may change

    jobs = {"scene": "ablation"}
    reads = {"scene": ("full_order/release",)}
    experiments = ("forced",)

    def of_scene(self, case: Case) -> xr.Dataset:
        """One entry an effect, the whole scene first."""
        whole, listed = FullOrder.of_scene(dict(case.scene), case.structure), case.scene["effects"]
        release = released(case.full_order["release"], "test")
        per_period, every = whole.steps_per_period, case.scene["time"]["every"]
        runs = Runs(
            whole,
            release + np.concatenate([whole.rest, np.zeros(whole.size)]),
            float(case.settings("forced")["forcing"]),
            every,
            self.decay_periods * per_period,
            self.forced_periods * per_period,
        )
        whole_body, first, truth = less(case.scene, runs, (), None)
        bodies = {WHOLE: whole_body} if truth is not None else {}
        records: dict[str, dict[str, Any]] = {}
        for name in listed:
            body, records[name], decay = less(case.scene, runs, (name,), truth)
            if decay is not None:
                bodies[name] = body
        advice = advise(
            records,
            first,
            self.tolerance,
            lambda names: less(case.scene, runs, names, truth)[1],
        )
        together = " ".join(advice.left_out) or WHOLE
        if together not in bodies and truth is not None:
            term = without(case.scene, advice.left_out)[0]
            bodies[together] = replace(whole, term=term, rest=linearised(term)[0])
        times = timed(bodies, runs, self)
        records = {WHOLE: first, **records}
        for name in records.keys() & times.keys():
            records[name] |= times[name]
        ratio = times.get(together, {}).get("seconds_ratio", np.nan)
        return self._dataset(case, records, runs).assign(variables(advice, ratio))

    def _dataset(self, case: Case, records: Mapping[str, Any], runs: Runs) -> xr.Dataset:
        spacing = runs.step * runs.every
        decay = spacing * np.arange(runs.decay_steps // runs.every + 1)
        last = spacing * np.arange(runs.whole.steps_per_period // runs.every + 1)
        sizes = {"probe": len(runs.whole.probes), "time": len(decay), "last_time": len(last)}
        return xr.Dataset(
            stacked(records.values(), {LEFT_OUT: len(records)}, COLUMNS, sizes),
            coords={
                LEFT_OUT: text(LEFT_OUT, list(records), "effect that is left out"),
                "probe": case.structure["probe"].variable,
                "time": variable("time", decay, "s", "time since release"),
                "last_time": variable(
                    "last_time", last, "s", "time in the last period of the forced run"
                ),
            },
            attrs={name: getattr(self, name) for name in (*LENGTHS, "tolerance")},
        )


def less(
    scene: Mapping[str, Any], runs: Runs, left_out: tuple[str, ...], truth: Any
) -> tuple[FullOrder, dict[str, Any], Any]:
    """The body without some effects, its record, and its decay, which is compared with `truth`,
    that of the whole scene, where that is known.
    """
    term, needed_by = without(scene, left_out)
    if needed_by:
        return runs.whole, {"outcome": Outcome.NEEDED, "needed_by": " ".join(needed_by)}, None
    title = f"{runs.whole.title}: without {' '.join(left_out) or WHOLE}"
    body, record, decay = evaluated(replace(runs.whole, term=term, title=title), runs)
    if decay is not None and (truth is not None or not left_out):
        record["decay_nmte"] = nmte_percent(decay if truth is None else truth, decay)
    return body, record, decay


def without(scene: Mapping[str, Any], left_out: tuple[str, ...]) -> tuple[Term, list[str]]:
    """The sum of all effects but some, and those that cannot be assembled without them."""
    body, total, needed_by = space.build(scene["body"]), Term(), []
    for name in in_order(scene["effects"]):
        if name not in left_out:
            try:
                total = total + effects.brought(name, scene["effects"][name], body, total)
            except (SceneError, RuntimeError):  # the latter from a stiffness that is singular
                needed_by.append(name)
    return total, needed_by


def evaluated(body: FullOrder, runs: Runs) -> tuple[FullOrder, dict[str, Any], Any]:
    """The body about its own rest state, its record, and its decay (times, n) [m] seen from the
    whole scene's rest state; None where it has none.
    """
    try:
        body = replace(body, rest=linearised(body.term)[0])
    except SceneError:
        return body, {"outcome": Outcome.NO_EQUILIBRIUM}, None
    record: dict[str, Any] = {"outcome": Outcome.OK}
    try:
        record["first_frequency"] = float(eigenmodes(body.term, 1)[0][0])
    except (SceneError, RuntimeError):
        record["outcome"] = Outcome.NO_MODES
    if body.term.mass is None or not body.term.mass.diagonal().all():
        return body, record | static_response(body, runs.forcing), None
    keep = Record(every=runs.every, probes=body.probes)
    scratch = room(1, keep.count(runs.decay_steps), runs.whole.size, runs.whole.rest)
    decay = runs.decay(body, runs.decay_steps, replace(keep, sink=scratch))
    away = body.rest - runs.whole.rest
    watched, motions = decay.probes[0], [decay]
    record |= {
        "decay_displacement": watched[:, :: runs.every] + away[body.probes, None],
        "decay_frequency": swing(watched, runs.step),
        "decay_amplitude": np.abs(watched[:, -body.steps_per_period :]).max(axis=1),
        "iterations_per_step": decay.iterations / runs.decay_steps,
    }
    if body.term.load is None:
        record["forced_amplitude"] = np.zeros(len(body.probes))
        if record["outcome"] is Outcome.OK:
            record["outcome"] = Outcome.UNFORCED
    else:
        driven = runs.forced(body)
        motions.append(driven)
        record["forced_amplitude"] = driven.probes[0].max(axis=1)
        record["forced_displacement"] = driven.probes[0][:, :: runs.every]
    for motion in motions:
        ended = Outcome(motion.outcomes[0])
        if not ended.has_value:
            record["outcome"] = ended
            record["failed_at"] = np.fmin(record.get("failed_at", np.nan), motion.failed_at[0])
    went_all_the_way = Outcome(decay.outcomes[0]).has_value
    seen = decay.displacement[0] + away if scratch is None else scratch.variable[0]
    return body, record, seen if went_all_the_way else None


def static_response(body: FullOrder, forcing: float) -> dict[str, Any]:
    """Largest displacement (probes,) [m] under the load held at plus and minus its amplitude."""
    if body.term.load is None:
        return {"outcome": Outcome.STATIC, "forced_amplitude": np.zeros(len(body.probes))}
    try:
        ends = [
            static.equilibrium(body.term, signal, start=body.rest) for signal in (forcing, -forcing)
        ]
    except SceneError:
        return {"outcome": Outcome.NO_EQUILIBRIUM}
    amplitude = np.max([(end - body.rest)[body.probes] for end in ends], axis=0)
    return {"outcome": Outcome.STATIC, "forced_amplitude": amplitude}


def swing(x: np.ndarray, step: float) -> np.ndarray:
    """Mean angular frequency (probes,) [rad/s] of x (probes, samples): half periods from the first
    to the last passage through rest.
    """
    found, time = np.full(len(x), np.nan), step * np.arange(x.shape[1])
    for index, one in enumerate(x):
        crossing, _ = crossings(time, one)
        if len(crossing) > 1:
            found[index] = np.pi * (len(crossing) - 1) / (crossing[-1] - crossing[0])
    return found


def timed(
    bodies: Mapping[str, FullOrder], runs: Runs, lengths: Ablation
) -> dict[str, dict[str, float]]:
    """Seconds a step of the first periods of each body's decay. The bodies take many short turns,
    in another order each round, so that a slow moment of the machine meets all of them; rounds are
    compared one by one, as its pace differs more from round to round than within one.
    """
    steps, order = lengths.timed_periods * runs.whole.steps_per_period, list(bodies)
    seconds: dict[str, list[float]] = {left_out: [] for left_out in bodies}
    for _ in range(lengths.repeats):
        order = [*order[1:], *order[:1]]
        for left_out in order:
            motion = runs.decay(bodies[left_out], steps, Record(start=steps))
            seconds[left_out].append(motion.seconds / steps)
    whole = seconds.get(WHOLE, [np.nan] * lengths.repeats)
    return {
        left_out: {
            "seconds_per_step": median(own),
            "seconds_ratio": median(full / less for full, less in zip(whole, own)),
        }
        for left_out, own in seconds.items()
    }
