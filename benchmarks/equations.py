"""A model from the equations: what it costs and how near the truth it is, without any data.

The truth is a decay of the folding cantilever with 8000 steps a period, no numerical damping and
accelerations that balance the forces at the start. Beside the model stands the full order at the
scene's own settings, from whose runs all other models learn. The large body has as many cells along
its length as keep them nearly square, and the same band.

The two force maps are compared where they differ, under damping by the stiffness: on nine motions
about resonance, as far as the model is trusted, against the full order.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from benchmarks.cantilever import NEWMARK, STEPS_PER_PERIOD, build, released
from benchmarks.table import Row, paired
from vibrom.methods.equations import Equations
from vibrom.models.full_order import FullOrder
from vibrom.models.measures import nmte_percent
from vibrom.models.model import Drive, Watch
from vibrom.models.reduced import Reduced
from vibrom.models.rollout import Integrator, rollout
from vibrom.models.training import Training
from vibrom.solvers.full.modes import eigenmodes, linearised
from vibrom.solvers.full.newmark import Newmark, Record
from vibrom.solvers.manifold.parametrisation import parametrise

ORDER, PERIODS, FINE, SAMPLES = 15, 30, 8000, 200
LARGE = (940, 7)  # cells: 15 040 displacements
# Of the comparison of force maps: periods, steps to each, times the load, of the first mode.
DRIVEN, COARSE, FORCING, RATIO = 120, 400, 100.0, 0.01


def decay(newmark: Newmark, steps: int, initial: str) -> np.ndarray:
    """SAMPLES displacements (m, n) a period."""
    model = build()
    return newmark.run(
        model.term,
        released()[:, None],
        np.array([2 * np.pi / model.frequency / steps]),
        PERIODS * steps,
        initial_acceleration=initial,
        record=Record(every=steps // SAMPLES),
    ).displacement[0]


def peaks(model: FullOrder | Reduced) -> np.ndarray:
    """(9,) m, largest displacement of the tip in the last of so many periods from rest."""
    frequency = np.linspace(0.96, 1.04, 9) * model.frequency
    drive = Drive(np.full(9, FORCING), frequency)
    period = DRIVEN - 1 + np.arange(1, COARSE + 1) / COARSE
    watch = Watch(drive.period[:, None] * period, model.probes)
    start = np.zeros((9, 2 * model.size))
    return model.motion(start, drive, watch).displacement[0][:, :, 0].max(axis=1)


def amplitude_errors() -> dict[str, float]:
    """Largest error [%] of the amplitude with each force map."""
    body, plain = build(), build().term
    omega, probes = eigenmodes(plain, 1).frequency[0], np.array([build().space.size - 1])
    term = replace(plain, damping=(2.0 * RATIO / omega * linearised(plain)[1]).tocsr())
    rest, poles = np.zeros(term.size), np.array([-RATIO + 1j]) * omega
    truth = peaks(
        FullOrder(
            term,
            probes,
            Newmark(tolerance=1e-6),
            COARSE,
            "equilibrium",
            body.frequency,
            poles,
            rest,
        )
    )
    found = {}
    for force in ("invariance", "symplectic"):
        rom = Equations(order=ORDER, force=force).learn(Training((), term=term))
        ours = peaks(Reduced(rom, term.load, probes, body.frequency, Integrator()))
        found[force] = 100.0 * float(np.abs(ours / truth - 1.0).max())
    return found


def measure(note) -> Iterator[Row]:
    term, large = build().term, build(cells=LARGE).term
    note(f"series of order {ORDER}")
    method, training = Equations(order=ORDER), Training((), term=term)
    seconds = paired(
        {
            "series": lambda: parametrise(term, (1,), ORDER),
            "model": lambda: method.learn(training),
        }
    )
    yield Row("equations", f"series of order {ORDER}, {term.size}", seconds["series"], "s")
    yield Row("equations", f"model with its trust, {term.size}", seconds["model"], "s")
    note(f"series of order {ORDER}, {large.size} displacements")
    whole = Training((), term=large)
    seconds = paired(
        {
            "series": lambda: parametrise(large, (1,), ORDER),
            "model": lambda: method.learn(whole),
        },
        repeats=1,
    )
    yield Row("equations", f"series of order {ORDER}, {large.size}", seconds["series"], "s")
    yield Row("equations", f"model with its trust, {large.size}", seconds["model"], "s")
    note("both force maps, under damping by the stiffness")
    errors = amplitude_errors()
    yield Row(
        "equations",
        "amplitude under damping by the stiffness, largest error",
        errors["invariance"],
        "%",
        "the symplectic force map",
        errors["symplectic"],
    )
    note(f"a converged decay of {PERIODS} periods")
    truth = decay(Newmark(tolerance=1e-9), FINE, "equilibrium")
    usual = decay(NEWMARK, STEPS_PER_PERIOD, "zero")
    rom = method.learn(training)
    state = np.concatenate([released(), np.zeros(term.size)])
    times = 2 * np.pi / build().frequency * np.arange(len(truth)) / SAMPLES
    run = rollout(rom, rom.encode(state[None]), times[None], Integrator())
    yield Row(
        "equations",
        "NMTE of the folding decay",
        nmte_percent(truth, rom.displacement(run.reduced[0])),
        "%",
        "the full order at the scene's settings",
        nmte_percent(truth, usual),
    )
