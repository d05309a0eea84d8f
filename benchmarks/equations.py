"""A model from the equations: what it costs and how near the truth it is, without any data.

The truth is a decay of the folding cantilever with 8000 steps a period, no numerical damping and
accelerations that balance the forces at the start. Beside the model stands the full order at the
scene's own settings, from whose runs all other models learn. The large body has as many cells along
its length as keep them nearly square, and the same band.
"""

from collections.abc import Iterator

import numpy as np

from benchmarks.cantilever import NEWMARK, STEPS_PER_PERIOD, build, released
from benchmarks.table import Row, paired
from vibrom.methods.equations import Equations
from vibrom.models.measures import nmte_percent
from vibrom.models.rollout import Integrator, rollout
from vibrom.models.training import Training
from vibrom.solvers.full.newmark import Newmark, Record
from vibrom.solvers.manifold.parametrisation import parametrise

ORDER, PERIODS, FINE, SAMPLES = 15, 30, 8000, 200
LARGE = (940, 7)  # cells: 15 040 displacements


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
    seconds = paired({"series": lambda: parametrise(large, (1,), ORDER)}, repeats=1)
    yield Row("equations", f"series of order {ORDER}, {large.size}", seconds["series"], "s")
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
