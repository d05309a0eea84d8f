"""What is not listed is not computed.

The folding cantilever with effects left out, one state alone and sixteen side by side. Without
geometric nonlinearity the operator is factorised once, and a step is one product and one solve. A
scene without load or damping is compared with one that moves alike: the load is there and its
signal is zero, the damping is there and its ratio is 1e-12. Each pair takes turns.
"""

from collections.abc import Iterator
from functools import partial

import numpy as np

from benchmarks.cantilever import NEWMARK, SCENE, build, released
from benchmarks.table import Row, paired
from vibrom import effects
from vibrom.solvers.full.newmark import Record
from vibrom.term import Term

STEPS = 16_000


def measure(note) -> Iterator[Row]:
    model, listed = build(), SCENE["effects"]
    silent = {**listed, "rayleigh_damping": {"damping_ratio": 1e-12}}

    def term(settings: dict, *without: str) -> Term:
        return effects.assemble(
            model.space, {name: block for name, block in settings.items() if name not in without}
        )

    def run(term: Term, states: int) -> None:
        start = np.repeat(released()[:, None], states, axis=1)
        NEWMARK.run(
            term,
            start,
            np.full(states, model.step),
            STEPS // states,
            signal=np.zeros((STEPS // states + 1, states)),
            initial_acceleration="zero",
            record=Record(every=STEPS),
        )

    note(f"{STEPS} state-steps each")
    for left_out, with_it in (
        ("geometric_nonlinearity", listed),
        ("modal_load", listed),
        ("rayleigh_damping", silent),
    ):
        for states in (1, 16):
            seconds = paired(
                {
                    "with": partial(run, term(with_it), states),
                    "without": partial(run, term(with_it, left_out), states),
                },
                repeats=7,
            )
            batch = "one state" if states == 1 else "sixteen"
            yield Row(
                "effects",
                f"microseconds per step and state without {left_out}, {batch}",
                1e6 * seconds["without"] / STEPS,
                "us",
                "with it",
                1e6 * seconds["with"] / STEPS,
            )
