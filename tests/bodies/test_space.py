"""Where a body's points, boundaries and degrees of freedom are; a new body is one file."""

import os
import subprocess
import sys

import numpy as np
import pytest
from project_copy import ROOT, copy
from scenes import LINEAR, THESIS, body

from vibrom import effects
from vibrom.artefacts.data import open_dataset
from vibrom.bodies import space
from vibrom.solvers.full import static
from vibrom.steps import structure
from vibrom.term import SceneError

ARCHED = {"rise": 0.3, "height": 0.1, "cells": [6, 2]}
ELEMENTS = ["bilinear", "quadratic", "serendipity"]


def probe(at, direction="y"):
    return {"tip": {"at": at, "direction": direction}}


@pytest.mark.parametrize("scale", [1.0, 1e-6])
def test_a_point_between_nodes_is_none_at_any_scale(scale):
    size = {"length": scale, "height": 0.02 * scale, "width": 0.05 * scale}
    made = space.build(body(**size, probes=probe([0.525 * scale, 0.0])))
    where = made.dof_location[made.probes["tip"]]
    assert where == pytest.approx([0.525 * scale, 0.0], abs=1e-9 * scale)
    off = [0.51 * scale, 0.0]
    with pytest.raises(SceneError) as refused:
        space.build(body(**size, probes=probe(off)))
    nearest = [0.5 * scale, 0.0]
    assert str(refused.value) == (
        f"body.probes.tip.at = {off} is no node of the mesh; the nearest one is {nearest}"
    )


@pytest.mark.parametrize(
    "at, direction, says",
    [
        ([0.0, 0.01], "y", "lies on the clamped boundary left and cannot move; choose another"),
        ([1.0, 0.01], "z", "Invalid enum value 'z'"),
        ([1.0, 0.01, 0.0], "y", "of length 2"),
    ],
)
def test_a_point_that_cannot_be_watched_is_refused(at, direction, says):
    with pytest.raises(SceneError) as refused:
        space.build(body(probes=probe(at, direction)))
    assert says in str(refused.value)


def test_a_plane_body_has_no_third_direction():
    with pytest.raises(SceneError, match="along 'z' is not in the body; give x, y of a node"):
        space.build(body()).dof("effects.point_load", [1.0, 0.01], "z")


@pytest.mark.parametrize("element", ELEMENTS)
def test_segments_run_around_the_body_on_their_left(element):
    """By Green's theorem the area is int (x dy - y dx)/2 around the body, whose edges are lines."""
    made = space.build(body(**ARCHED, element=element))
    around = [made.segments(edge) for edge in ("left", "right", "bottom", "top")]
    first, last = (np.concatenate([part[:, end] for part in around]).T for end in (0, -1))
    (x0, y0), (x1, y1) = (
        made.basis.doflocs[[0, 1]][:, dofs].diagonal().T for dofs in (first, last)
    )
    assert np.sum(x0 * y1 - x1 * y0) / 2 == pytest.approx(made.basis.dx.sum(), rel=1e-12)


@pytest.mark.parametrize("element", ELEMENTS)
def test_vertices_of_dofs_are_where_the_dofs_are(element):
    made = space.build(body(**ARCHED, element=element))
    at_vertex = made.dof_vertex >= 0
    found = made.basis.mesh.p[:, made.dof_vertex[at_vertex]].T
    assert np.array_equal(found, made.dof_location[at_vertex])
    assert at_vertex.all() == (element == "bilinear") and at_vertex.any()


@pytest.mark.parametrize("element", ELEMENTS)
def test_the_coarsest_mesh_has_a_structure(tmp_path, element):
    path = tmp_path / "structure.nc"
    scene = {"body": body(cells=[1, 1], element=element), "effects": THESIS}
    structure.run(structure=str(path), scene=scene, name="coarse", provenance={})
    known = open_dataset(path, "structure")
    assert known.sizes["mode"] == min(structure.MODES, known.sizes["dof"])
    assert (known["frequency"] > 0).all() and (np.diff(known["frequency"]) >= 0).all()


def test_a_body_that_cannot_move_is_refused():
    with pytest.raises(SceneError, match="body.clamped leaves nothing to move"):
        space.build(body(cells=[1, 1], clamped=["left", "right"]))


ANGLE = '''"""An L of two square arms."""

from dataclasses import dataclass

import numpy as np
import skfem

from vibrom.bodies.space import Probe, Space, movable
from vibrom.config.kinds import Count, Name, Positive


@dataclass(frozen=True)
class Angle:
    arm: Positive  # m
    cells: Count  # over an arm
    probes: dict[Name, Probe]

    def build(self) -> Space:
        lines = np.linspace(0.0, 2.0 * self.arm, 2 * self.cells + 1)
        mesh = skfem.MeshQuad.init_tensor(lines, lines).with_defaults()
        mesh = mesh.remove_elements(mesh.elements_satisfying(lambda x: x.min(axis=0) > self.arm))
        basis = skfem.Basis(mesh, skfem.ElementVector(skfem.ElementQuad1()), intorder=3)
        free = movable(basis, ["left"])
        scalar = basis.with_element(skfem.ElementQuad1())
        made = Space(basis, scalar, self.arm, ("left",), free, basis.doflocs, {})
        return made.watched(self.probes)
'''
RUN = """
import sys
from pathlib import Path
from vibrom import effects
from vibrom.bodies import space
from vibrom.config import settings
from vibrom.solvers.full import static
scene = settings.load(Path(sys.argv[1]) / "config", command={"scenes": ["bent"]}).scenes["bent"]
made = space.build(scene.body)
print(static.equilibrium(effects.assemble(made, scene.effects), 1.0)[made.probes["corner"]])
"""


def test_a_new_body_is_one_file(tmp_path):
    """It is softer than the square, of which it lacks a quarter."""
    copy(tmp_path, "src")
    (tmp_path / "src/vibrom/bodies/angle.py").write_text(ANGLE)
    scene = (ROOT / "config/scenes/small.yaml").read_text()
    head, rest = scene.split("body:")[0], scene[scene.index("effects:") :]
    loaded = rest.replace("modal_load: {mode: 1}", "point_load: {at: [2.0, 0.0], direction: y}")
    block = "{shape: angle, arm: 1.0, cells: 4, probes: {corner: {at: [2.0, 0.0], direction: y}}}"
    (tmp_path / "config/scenes/bent.yaml").write_text(f"{head}body: {block}\n{loaded}")
    done = subprocess.run(
        [sys.executable, "-c", RUN, str(tmp_path)],
        capture_output=True,
        text=True,
        env=os.environ | {"PYTHONPATH": str(tmp_path / "src")},
    )
    assert done.returncode == 0, done.stderr
    size = {"length": 2.0, "height": 2.0, "width": 1.0, "cells": [8, 8]}
    square = space.build(body(**size, probes=probe([2.0, 0.0])))
    load = {"point_load": {"at": [2.0, 0.0], "direction": "y"}}
    whole = static.equilibrium(effects.assemble(square, {**LINEAR, **load}), 1.0)
    assert 1.0 < float(done.stdout) / whole[square.probes["tip"]] < 3.0
