"""Recorded motion of a beam of three elements, made by the steps of the workflow."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
import pytest
import scenes
import xarray as xr

from vibrom import effects
from vibrom.artefacts.data import open_dataset
from vibrom.bodies import space
from vibrom.models import recorded
from vibrom.models.training import Structure, Trajectory
from vibrom.steps import record, release, structure
from vibrom.term import Term

BODY = {**scenes.body(cells=[3, 1], element="quadratic"), "shape": "rectangle"}
SCENE = {
    "body": {**BODY, "probes": {"tip": {"at": [1.0, 0.0], "direction": "y"}}},
    "effects": scenes.THESIS,
    "releases": {role: {"forcing": 500.0, "step": 650} for role in ("train", "test")},
    "record": {"periods": 15, "derivatives": "integrator"},
    "time": {
        "steps_per_period": 200,
        "every": 1,
        "alpha": 0.005,
        "residual": 1e-8,
        "initial_acceleration": "equilibrium",
    },
}
# Loads of every kind: shaped like the motion, at one node, and of a support that shakes.
LOADS = {
    "modal": {"modal_load": {"mode": 1}},
    "tip": {"point_load": {"at": [1.0, 0.0], "direction": "y"}},
    "middle": {"point_load": {"at": [0.5, 0.02], "direction": "y"}},
    "base": {"base_motion": {"direction": "y"}},
}


@dataclass(frozen=True)
class Beam:
    """The artefacts of the scene."""

    folder: Path  # structure.nc, release.nc and train.nc
    known: xr.Dataset  # its structure
    train: xr.Dataset  # its decay

    @cached_property
    def structure(self) -> Structure:
        return recorded.structure(self.known)

    @cached_property
    def trajectory(self) -> Trajectory:
        return recorded.trajectory(self.train)

    @cached_property
    def term(self) -> Term:
        return effects.assemble(space.build(SCENE["body"]), SCENE["effects"])

    def load(self, name: str) -> np.ndarray:
        """(n,) N per unit of the signal."""
        linear = {key: scenes.THESIS[key] for key in ("inertia", "elasticity")}
        return effects.assemble(space.build(SCENE["body"]), linear | LOADS[name]).load


@pytest.fixture(scope="session")
def beam(tmp_path_factory) -> Beam:
    folder = tmp_path_factory.mktemp("beam")
    known, start, train = (str(folder / f"{name}.nc") for name in ("structure", "release", "train"))
    structure.run(structure=known, scene=SCENE, name="beam", provenance={})
    release.run(structure=known, release=start, scene=SCENE, provenance={})
    record.run(
        structure=known, release=start, trajectory=train, scene=SCENE, role="train", provenance={}
    )
    return Beam(folder, open_dataset(known, "structure"), open_dataset(train, "trajectory"))
