"""Structure, release state -> effects.nc: what each effect of a scene is worth, told by leaving it
out.

The whole scene, and the scene less one effect at a time, answer the same questions: first
frequency; a decay from the test release; a forced run from rest; seconds a step. Instants,
frequency and amplitude of the forcing are those of the whole scene, and all bodies are let go from
the same place in space. What is compared is where a body goes, seen from the rest state of the
whole scene; amplitudes are told from the rest state of each. An effect that another one needs
cannot be left out alone (outcome `needed_by ...`); without mass everywhere only the static answer
is left.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from statistics import median

import numpy as np
import xarray as xr

from vibrom import effects
from vibrom.artefacts.data import label, open_dataset, save_dataset, variable
from vibrom.artefacts.hardware import description
from vibrom.bodies.space import Space
from vibrom.models.full_order import FullOrder, build, probe_coordinate
from vibrom.models.measures import nmte_percent
from vibrom.solvers.full import static
from vibrom.solvers.full.modes import eigenmodes, linearised
from vibrom.solvers.full.newmark import Motion, Record
from vibrom.term import SceneError, Term

NOTHING = "nothing"  # the effect that the whole scene leaves out


@dataclass
class Answer:
    """One scene's answers; NaN where it has none. decay (probes, times) and forced (probes, times)
    [m], the latter the last period.
    """

    outcome: str = "ok"
    failed_at: float = np.nan
    first_frequency: float = np.nan
    decay: np.ndarray | None = None
    decay_nmte: float = np.nan
    decay_frequency: np.ndarray | float = np.nan
    decay_amplitude: np.ndarray | float = np.nan
    forced: np.ndarray | None = None
    forced_amplitude: np.ndarray | float = np.nan
    iterations: float = np.nan
    seconds: list[float] = field(default_factory=list)


def run(
    *, structure: str, release: str, output: str, scene: dict, lengths: dict, provenance: dict
) -> None:
    model = build(scene, structure)
    start = open_dataset(release, "release")["displacement"].sel(role="test").values
    listed, answers, movable, whole = scene["effects"], {}, {}, None
    for left_out in (NOTHING, *listed):
        term, needed_by = without(model.space, listed, left_out)
        if needed_by:
            answers[left_out] = Answer(f"needed_by {' '.join(needed_by)}")
            continue
        answers[left_out], body, decay = ask(
            replace(model, term=term),
            model.rest,
            start,
            scene["experiments"]["forced"]["forcing"],
            lengths,
            left_out,
        )
        whole = decay if left_out == NOTHING else whole
        if decay is not None:
            movable[left_out] = body
            answers[left_out].decay_nmte = (
                np.nan
                if whole is None
                else nmte_percent(np.linalg.norm(decay - whole, axis=1), whole)
            )
    take_turns(movable, model.rest + start, answers, lengths)
    save_dataset(
        label(
            collected(answers, model, lengths),
            "effects",
            scene=model.name,
            method="full_order",
            hardware=description(),
            **lengths,
        ),
        output,
        provenance,
    )


def without(space: Space, listed: dict, left_out: str) -> tuple[Term, list[str]]:
    """The sum of all effects but one, and those that cannot be assembled without it."""
    total, needed_by = Term(), []
    for name, settings in listed.items():
        if name != left_out:
            try:
                total = total + effects.load(name, settings).assemble(space, total)
            except (
                SceneError,
                RuntimeError,
            ):  # a factorisation of what has no stiffness left ends in the latter
                needed_by.append(name)
    return total, needed_by


def ask(
    model: FullOrder,
    origin: np.ndarray,
    start: np.ndarray,
    forcing: float,
    lengths: dict,
    left_out: str,
):
    """The answers of a body, the body about its own rest state, and its decay (times, n) [m] seen
    from `origin`, None where it has none.
    """
    answer = Answer()
    try:
        model = replace(model, rest=linearised(model.term)[0])
    except SceneError:
        return Answer("no_equilibrium"), model, None
    probes, title = model.probes, f"{model.name}: without {left_out}"
    try:
        answer.first_frequency = float(eigenmodes(model.term, 1)[0][0])
    except (SceneError, RuntimeError):
        answer.outcome = "no_modes"
    if model.term.mass is None or not model.term.mass.diagonal().all():
        try:
            answer.outcome, answer.forced_amplitude = "static", static_amplitude(model, forcing)
        except SceneError:
            answer.outcome = "no_equilibrium"
        return answer, model, None
    moved = decayed(
        model,
        origin + start,
        lengths["decay_periods"],
        Record(every=model.every, probes=probes),
        title,
    )
    seen = moved.displacement[0] + model.rest - origin
    watched = moved.probes[0]
    answer.decay = watched[:, :: model.every] + (model.rest - origin)[probes, None]
    answer.decay_frequency, answer.decay_amplitude = (
        swing(watched, model.period / model.steps_per_period),
        np.abs(watched[:, -model.steps_per_period :]).max(axis=1),
    )
    answer.iterations = moved.iterations / (lengths["decay_periods"] * model.steps_per_period)
    motions = [moved]
    if model.term.load is None:
        answer.outcome = "unforced" if answer.outcome == "ok" else answer.outcome
        answer.forced_amplitude = np.zeros(len(probes))
    else:
        steps = lengths["forced_periods"] * model.steps_per_period
        record = Record(start=steps + 1, probes=probes, probe_start=steps - model.steps_per_period)
        driven = model.forced(
            np.array([float(forcing)]),
            np.array([model.frequency]),
            steps,
            record,
            f"{title}, forced",
        )
        answer.forced_amplitude, answer.forced = (
            driven.probes[0].max(axis=1),
            driven.probes[0][:, :: model.every],
        )
        motions.append(driven)
    for motion in motions:
        if motion.outcomes[0] != "ok":
            answer.outcome, answer.failed_at = (
                motion.outcomes[0],
                np.fmin(answer.failed_at, motion.failed_at[0]),
            )
    return answer, model, seen if moved.outcomes[0] == "ok" else None


def decayed(
    model: FullOrder, where: np.ndarray, periods: int, record: Record, title: str
) -> Motion:
    """The motion of a body let go at `where` (n,) [m], counted from its undeformed state."""
    step = np.array([model.period / model.steps_per_period])
    return model.run(
        (where - model.rest)[:, None], step, periods * model.steps_per_period, record, title
    )


def swing(x: np.ndarray, step: float) -> np.ndarray:
    """Mean angular frequency (probes,) [rad/s] of x (probes, samples): half periods from the first
    to the last passage through rest.
    """
    found = np.full(len(x), np.nan)
    for index, one in enumerate(x):
        (before,) = np.nonzero(np.signbit(one[:-1]) != np.signbit(one[1:]))
        if len(before) > 1 and np.isfinite(one).all():
            crossing = before - one[before] / (one[before + 1] - one[before])
            found[index] = np.pi * (len(crossing) - 1) / ((crossing[-1] - crossing[0]) * step)
    return found


def static_amplitude(model: FullOrder, forcing: float) -> np.ndarray:
    """Largest displacement (probes,) [m] under the load held at plus and minus its amplitude."""
    if model.term.load is None:
        return np.zeros(len(model.probes))
    ends = [
        static.equilibrium(model.term, signal, start=model.rest) for signal in (forcing, -forcing)
    ]
    return np.max([(end - model.rest)[model.probes] for end in ends], axis=0)


def take_turns(
    bodies: dict[str, FullOrder], where: np.ndarray, answers: dict[str, Answer], lengths: dict
) -> None:
    """Seconds a step of the first periods of each body's decay. They take many short turns, in
    another order each round, so that a slow moment of the machine meets all of them.
    """
    order = list(bodies.items())
    for turn in range(lengths["repeats"]):
        order = [*order[1:], *order[:1]]
        for left_out, model in order:
            steps = lengths["timed_periods"] * model.steps_per_period
            title = f"{model.name}: without {left_out}, timed {turn + 1} of {lengths['repeats']}"
            motion = decayed(model, where, lengths["timed_periods"], Record(start=steps), title)
            answers[left_out].seconds.append(motion.seconds / steps)


def collected(answers: dict[str, Answer], model: FullOrder, lengths: dict) -> xr.Dataset:
    step, probes = model.period / model.steps_per_period, len(model.probes)
    per_period = model.steps_per_period // model.every

    def each(name: str, *shape: int) -> np.ndarray:
        values = [getattr(answer, name) for answer in answers.values()]
        return np.array(
            [np.broadcast_to(np.nan if value is None else value, shape) for value in values]
        )

    seconds = {name: answer.seconds or [np.nan] for name, answer in answers.items()}
    # Rounds are compared one by one: the machine's pace differs more from round to round than
    # within one.
    ratio = [
        median(whole / less for whole, less in zip(seconds[NOTHING], one))
        for one in seconds.values()
    ]
    names, left_out, at = list(answers), "left_out", ("left_out", "probe")
    return xr.Dataset(
        {
            "first_frequency": variable(
                left_out,
                each("first_frequency"),
                "rad s-1",
                "undamped first angular frequency about the rest state",
            ),
            "decay_nmte": variable(
                left_out,
                each("decay_nmte"),
                "percent",
                "normalised mean-trajectory error of the decay against the whole scene's",
            ),
            "decay_frequency": variable(
                at,
                each("decay_frequency", probes),
                "rad s-1",
                "mean angular frequency of the decay",
            ),
            "decay_amplitude": variable(
                at,
                each("decay_amplitude", probes),
                "m",
                "largest displacement from rest in the last period of the decay",
            ),
            "decay_displacement": variable(
                (*at, "time"),
                each("decay", probes, lengths["decay_periods"] * per_period + 1),
                "m",
                "decay at the probes",
            ),
            "forced_amplitude": variable(
                at,
                each("forced_amplitude", probes),
                "m",
                "largest displacement in the last period of the forced run, or the static one",
            ),
            "forced_displacement": variable(
                (*at, "last_time"),
                each("forced", probes, per_period + 1),
                "m",
                "last period of the forced run at the probes",
            ),
            "iterations_per_step": variable(
                left_out, each("iterations"), "1", "Newton iterations a step of the decay"
            ),
            "seconds_per_step": variable(
                left_out,
                np.array([median(one) for one in seconds.values()]),
                "s",
                "wall time of a step of the decay's first periods, median of runs that take turns; loading and compilation excluded",
            ),
            "seconds_ratio": variable(
                left_out,
                np.array(ratio),
                "1",
                "wall time of the whole scene's step over that of one without the effect: median over the turns",
            ),
            "outcome": variable(
                left_out,
                np.array([answer.outcome for answer in answers.values()], dtype=object),
                "1",
                "how it ended",
            ),
            "failed_at": variable(
                left_out, each("failed_at"), "s", "simulated time at which a run failed"
            ),
        },
        coords={
            left_out: variable(
                left_out, np.array(names, dtype=object), "1", "effect that is left out"
            ),
            "probe": probe_coordinate(model),
            "time": variable(
                "time",
                np.arange(lengths["decay_periods"] * per_period + 1) * step * model.every,
                "s",
                "time since release",
            ),
            "last_time": variable(
                "last_time",
                np.arange(per_period + 1) * step * model.every,
                "s",
                "time in the last period of the forced run",
            ),
        },
    )
