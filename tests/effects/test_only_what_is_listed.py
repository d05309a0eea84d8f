"""An effect costs one file and one line of a scene; one that is not listed is not imported, and
none of its kernels compiled.
"""

import json
import os
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
import yaml
from project_copy import copy
from scenes import BEAM, THESIS, quadratic_body

from vibrom import effects
from vibrom.artefacts.data import open_dataset
from vibrom.bodies import space
from vibrom.config import plugs
from vibrom.models.full_order import FullOrder
from vibrom.models.model import Drive, Watch
from vibrom.solvers.full import static
from vibrom.steps import structure
from vibrom.term import SceneError

ROOT = Path(__file__).parents[2]
SCENES = {
    path.stem: yaml.safe_load(path.read_text()) for path in (ROOT / "config/scenes").glob("*.yaml")
}
TIP = {"tip": {"at": [1.0, 0.01], "direction": "y"}}


def python(code: str, *arguments: str, path: Path = ROOT / "src") -> str:
    done = subprocess.run(
        [sys.executable, "-c", code, *arguments],
        capture_output=True,
        text=True,
        env=os.environ | {"PYTHONPATH": str(path)},
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_the_class_that_assembles_is_the_effect(monkeypatch):
    """A file may have helpers beside it, but one effect only."""
    module = ModuleType("vibrom.effects.extra")
    monkeypatch.setitem(sys.modules, module.__name__, module)
    exec(
        "from dataclasses import dataclass\nclass Helper: pass\n"
        "@dataclass\nclass Extra:\n    def assemble(self, space, base): pass",
        vars(module),
    )
    assert type(effects.load("extra", {})) is module.Extra
    exec("class Another(Extra): pass", vars(module))
    with pytest.raises(
        SceneError,
        match="effects/extra.py defines 2 classes with a `assemble`; define exactly one",
    ):
        effects.load("extra", {})


COUNTED = """
import json, sys
from vibrom.kernels import compiled as store
compiled, njit = set(), store.njit
def counting(*signature, **options):
    def compile(function):
        compiled.add(function.__module__)
        return njit(*signature, **options)(function)
    return compile
store.njit = counting
from vibrom import effects
from vibrom.bodies import space
from vibrom.solvers.full import static
body, scenes = json.loads(sys.argv[1])
for scene in scenes:
    static.equilibrium(effects.assemble(space.build(body), scene), 1.0)
    home = "vibrom.effects."
    print(json.dumps([sorted(name.removeprefix(home) for name in names if name.startswith(home))
                      for names in (sys.modules, compiled)]))
"""


def test_unlisted_effects_are_neither_imported_nor_compiled():
    linear = {"elasticity": BEAM["elasticity"], "point_load": {"at": [1.0, 0.0], "direction": "y"}}
    stopped = {
        **linear,
        "stop": {"at": [1.0, 0.0], "direction": "y", "gap": 1e-6, "stiffness": 1e6},
    }
    seen = python(
        COUNTED, json.dumps([quadratic_body(cells=[2, 1]), [linear, stopped]])
    ).splitlines()
    assert [json.loads(line) for line in seen] == [
        [sorted(linear), []],
        [sorted(stopped), ["stop"]],
    ]


@pytest.mark.parametrize("name", SCENES)
def test_every_scene_has_what_its_effects_bring(name):
    body = SCENES[name]["body"]
    if "mesh" in body:
        body = {**body, "mesh": str(ROOT / "config/scenes" / body["mesh"])}
    made = space.build(body)
    term = effects.assemble(made, SCENES[name]["effects"])
    assert set(SCENES[name]["effects"]) <= set(plugs.names("effects"))
    assert len(term.forces) == sum(
        effect
        in ("geometric_nonlinearity", "cubic_spring", "stop", "follower_load", "dry_friction")
        for effect in SCENES[name]["effects"]
    )
    assert term.load is not None and (term.dead_load is not None) == (
        "gravity" in SCENES[name]["effects"]
    )


QUINTIC = '''"""A spring from one node to the ground: f = k u^5."""

from dataclasses import dataclass

import numpy as np

from vibrom.config.kinds import Point
from vibrom.term import Force, Term, force_kernel, tangent_kernel


@dataclass(frozen=True)
class QuinticSpring:
    at: Point  # m
    strength: float  # N/m^5

    def assemble(self, space, base):
        dof = space.dof("effects.quintic_spring", self.at, "y")
        kernels = lambda width: (force, tangent)
        return Term(forces=(Force(kernels, np.array([[dof]]), np.array([[self.strength]])),))


@force_kernel
def force(q, v, dofs, table, f):
    for w in range(q.shape[1]):
        f[dofs[0, 0], w] += table[0, 0] * q[dofs[0, 0], w] ** 5


@tangent_kernel
def tangent(q, v, dofs, table, slots, scale_q, scale_v, values):
    for w in range(q.shape[1]):
        values[slots[0, 0], w] += scale_q[w] * 5.0 * table[0, 0] * q[dofs[0, 0], w] ** 4
'''
RUN = """
import sys
from pathlib import Path
from vibrom import effects
from vibrom.config import settings
from vibrom.bodies import space
from vibrom.solvers.full import static
scene = settings.load(Path(sys.argv[1]) / "config", command={"scenes": ["held"]}).scenes["held"]
made = space.build(scene.body)
print(static.equilibrium(effects.assemble(made, scene.effects), 1000.0)[made.probes["tip"]])
"""


def test_a_new_effect_is_one_file_and_one_line(tmp_path):
    copy(tmp_path, "src")
    (tmp_path / "src/vibrom/effects/quintic_spring.py").write_text(QUINTIC)
    body, strength = quadratic_body(cells=[4, 1], probes=TIP), 1e8
    scene = {
        **SCENES["small"],
        "body": body,
        "effects": {
            **BEAM,
            "point_load": {"at": [1.0, 0.01], "direction": "y"},
            "quintic_spring": {"at": [1.0, 0.01], "strength": strength},
        },
    }
    (tmp_path / "config/scenes/held.yaml").write_text(yaml.safe_dump(scene, sort_keys=False))
    u = float(python(RUN, str(tmp_path), path=tmp_path / "src"))
    made = space.build(body)
    free = static.equilibrium(
        effects.assemble(made, {name: scene["effects"][name] for name in (*BEAM, "point_load")}),
        1.0,
    )[made.probes["tip"]]
    # The spring pulls at the node that is loaded: both meet the beam's own stiffness there. Solved
    # to 1e-8.
    assert u / free + strength * u**5 == pytest.approx(1000.0, rel=1e-6)
    assert u < 0.99 * 1000.0 * free


def test_a_body_with_weight_is_measured_from_where_it_hangs(tmp_path):
    """structure.nc holds the equilibrium and the tangent there; what runs about it starts at zero
    and, unforced, stays there.
    """
    body = quadratic_body(cells=[6, 1], probes=TIP)
    scene = {
        "body": body,
        "effects": {**THESIS, "gravity": {"y": -10000.0}},
        "time": SCENES["small"]["time"],
    }
    for name, listed in (("heavy", scene["effects"]), ("light", THESIS)):
        structure.run(
            structure=str(tmp_path / f"{name}.nc"),
            scene={**scene, "effects": listed},
            name=name,
            provenance={},
        )
    heavy, light = (
        open_dataset(tmp_path / f"{name}.nc", "structure") for name in ("heavy", "light")
    )
    assert "equilibrium" not in light and heavy["frequency"][0] > 1.001 * light["frequency"][0]
    model = FullOrder.of_scene(scene, heavy)
    assert np.abs(model.rest).max() > 0.1
    unforced = Drive(np.zeros(1), np.array([model.frequency]))
    instants = unforced.period[0] / model.steps_per_period * np.arange(1, 21)
    run = model.motion(np.zeros((1, 2 * model.size)), unforced, Watch(instants))
    # The rest state is solved to 1e-8 of the load, a step to 1e-6.
    assert np.abs(run.displacement[0]).max() < 1e-5 * np.abs(model.rest).max()
