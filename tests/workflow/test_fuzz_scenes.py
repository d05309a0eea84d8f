"""Whatever a scene asks for, its structure is numbers, or the answer is one line.

Sizes and properties of every order of magnitude, any effects together; VIBROM_FUZZ is how many.
"""

import os

import numpy as np
import xarray as xr
import yaml
from hypothesis import HealthCheck, Phase, given, seed, settings
from hypothesis import strategies as some
from project_copy import ROOT

from vibrom.artefacts.data import open_dataset
from vibrom.config import settings as configuration
from vibrom.steps import structure

CASES = int(os.environ.get("VIBROM_FUZZ", "60"))
FOLDING = yaml.safe_load((ROOT / "config/scenes/folding.yaml").read_text())
PROVENANCE = {"source_digest": "0", "versions": "{}"}

usual = some.floats(0.01, 100.0)
size = some.one_of(usual, usual, some.floats(-60.0, 60.0).map(lambda power: 10.0**power))
signed = some.one_of(size, size.map(lambda value: -value), some.just(0.0))
corner = some.sampled_from([[1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.5, 0.0]])  # in lengths
direction = some.sampled_from(["x", "y"])
EFFECTS = {
    "elasticity": {"young_modulus": size, "poisson_ratio": some.floats(-0.9, 0.49)},
    "geometric_nonlinearity": {},
    "gravity": {"x": signed, "y": signed},
    "follower_load": {"edge": some.sampled_from(["left", "right", "top"]), "pressure": signed},
    "base_motion": {"direction": direction},
    "modal_load": {"mode": some.integers(1, 12)},
    "point_load": {"at": corner, "direction": direction},
    "rayleigh_damping": {"damping_ratio": some.floats(0.0, 0.99), "stiffness_factor": size},
    "tip_mass": {"at": corner, "mass": size},
    "cubic_spring": {"at": corner, "direction": direction, "linear": signed, "cubic": signed},
    "stop": {"at": corner, "direction": direction, "gap": size, "stiffness": size},
}


@some.composite
def scenes(draw):
    """A scene's file: one body, and any of the effects."""
    length, height = draw(size), draw(size)

    def placed(block):
        at = {"at": [block["at"][0] * length, block["at"][1] * height]} if "at" in block else {}
        return block | at

    # Most bodies are elastic: the others are refused at once.
    chosen = draw(some.sets(some.sampled_from(sorted(EFFECTS)))) | draw(
        some.sampled_from([{"elasticity"}, {"elasticity", "geometric_nonlinearity"}, set()])
    )
    effects = {name: placed(draw(some.fixed_dictionaries(EFFECTS[name]))) for name in chosen}
    body = {
        "length": length,
        "height": height,
        "width": draw(size),
        "cells": draw(some.tuples(some.integers(1, 4), some.integers(1, 3)).map(list)),
        "element": draw(some.sampled_from(["bilinear", "quadratic", "serendipity"])),
        "clamped": draw(
            some.lists(some.sampled_from(["left", "right", "bottom"]), min_size=1, unique=True)
        ),
        "probes": {"tip": placed({"at": draw(corner), "direction": draw(direction)})},
        "rise": draw(some.sampled_from([0.0, 0.0, 0.1 * length, length])),
    }
    return FOLDING | {"body": body, "effects": effects | {"inertia": {"density": draw(size)}}}


def holds_numbers(dataset: xr.Dataset) -> bool:
    return all(
        np.isfinite(array.values).all()
        for array in dataset.variables.values()
        if array.dtype.kind == "f"
    )


@seed(0)
@settings(
    max_examples=CASES,
    deadline=None,
    database=None,
    phases=[Phase.generate],  # the first that fails is small enough
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture],
)
@given(scene=scenes())
def test_any_scene_has_a_structure_or_one_line(project, scene):
    (project / "config/scenes/folding.yaml").write_text(yaml.safe_dump(scene))
    overlay = project / "config/one.yaml"
    overlay.write_text("scenes: [folding]\nstudies: {cost: null, robustness: null}\n")
    path = project / "structure.nc"
    try:
        made = configuration.load(project / "config", [overlay]).scenes["folding"].to_builtins()
        structure.run(structure=str(path), scene=made, name="folding", provenance=PROVENANCE)
    except Exception as error:
        if type(error).__module__.split(".")[0] != "vibrom":
            raise
        assert "\n" not in str(error) and len(str(error)) < 500
    else:
        assert holds_numbers(open_dataset(path, "structure"))
