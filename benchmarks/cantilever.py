"""The thesis's folding cantilever, built for a benchmark."""

from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
import yaml

from vibrom import effects
from vibrom.bodies import space
from vibrom.bodies.space import Space
from vibrom.solvers.full.modes import eigenmodes
from vibrom.solvers.full.newmark import Newmark, Record
from vibrom.term import Term

SCENE = yaml.safe_load(Path("config/scenes/folding.yaml").read_text())
STEPS_PER_PERIOD = SCENE["time"]["steps_per_period"]


@dataclass(frozen=True)
class Cantilever:
    space: Space
    term: Term
    frequency: float  # damped first angular frequency [rad/s]

    @property
    def step(self) -> float:
        return 2 * np.pi / (self.frequency * STEPS_PER_PERIOD)


NEWMARK = Newmark(alpha=SCENE["time"]["alpha"], tolerance=SCENE["time"]["residual"])


@cache
def build(
    without: tuple[str, ...] = (),
    element: str = "bilinear",
    cells: tuple[int, ...] = (40, 2),  # three of a body in space, which is as wide as high
    length: float = 1.0,
) -> Cantilever:
    """The scene, less some effects, on another mesh."""
    size = {"element": element, "cells": list(cells), "length": length, "probes": {}}
    if len(cells) == 3:
        size |= {"shape": "block", "width": SCENE["body"]["height"]}
    body = space.build({**SCENE["body"], **size})
    term = effects.assemble(
        body, {name: block for name, block in SCENE["effects"].items() if name not in without}
    )
    return Cantilever(
        body,
        term,
        eigenmodes(term, 1)[0][0]
        * np.sqrt(1 - SCENE["effects"]["rayleigh_damping"]["damping_ratio"] ** 2),
    )


@cache
def released() -> np.ndarray:
    """The displacement (n,) from which the folding test decay starts [m]."""
    model, release = build(), SCENE["releases"]["test"]
    steps = release["step"]
    phase = 2 * np.pi * np.arange(steps + 1)[:, None] / STEPS_PER_PERIOD
    motion = NEWMARK.run(
        model.term,
        np.zeros((model.space.size, 1)),
        np.array([model.step]),
        steps,
        signal=release["forcing"] * np.sin(phase),
        initial_acceleration="zero",
        record=Record(every=steps),
    )
    return motion.displacement[0, -1]
