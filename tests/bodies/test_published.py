"""Frequencies of meshed bodies against published ones, and of a coarse mesh against a fine one."""

import runpy
from pathlib import Path

import numpy as np
import pytest
import skfem
from meshes import spaced

from vibrom import effects
from vibrom.bodies import space
from vibrom.bodies.elements import KINDS
from vibrom.solvers.full.modes import eigenmodes

STEEL = {
    "inertia": {"density": 8000.0},
    "elasticity": {"young_modulus": 200.0e9, "poisson_ratio": 0.3, "plane": "stress"},
}
# Hz; NAFEMS test FV32, a tapered membrane that is clamped at its wide end (The Standard NAFEMS
# Benchmarks, 1990).
FV32 = [44.623, 130.03, 162.70, 246.05, 379.90, 391.44]
PERFORATED = {"width": 0.05, "clamped": ["fixed"], "probes": {}}


@pytest.mark.parametrize("kind, within", [("triangle6", 2e-3), ("quad8", 2e-3), ("quad9", 2e-3)])
def test_a_tapered_membrane_has_the_frequencies_of_nafems(kind, within):
    """10 m long, 5 m and 1 m wide, in 16 x 8 cells."""
    first = skfem.MeshTri1 if kind == "triangle6" else skfem.MeshQuad1
    mesh = first.init_tensor(np.linspace(0, 10, 17), np.linspace(-0.5, 0.5, 9))
    mesh.p[1] *= 5.0 - 0.4 * mesh.p[0]
    made = spaced(KINDS[kind].mesh.from_mesh(mesh), kind)
    found = eigenmodes(effects.assemble(made, STEEL), 6).frequency / (2 * np.pi)
    np.testing.assert_allclose(found, FV32, rtol=within)


def test_a_beam_with_a_hole_has_the_frequencies_of_a_fine_mesh(tmp_path):
    """Three times as many rows: the mesh of the scene is a few parts in a thousand too stiff,
    most in the fourth mode.
    """
    script = Path("config/scenes/perforated_beam.py")
    text = script.read_text()
    fine = text.replace("ROWS = 2", "ROWS = 6").replace("MIDDLE - half, 5)", "MIDDLE - half, 15)")
    for name, content in (("coarse", text), ("fine", fine)):
        path = tmp_path / f"{name}.py"
        path.write_text(content)
        runpy.run_path(str(path), run_name="__main__")
    coarse, fine = (
        space.build({**PERFORATED, "mesh": str(tmp_path / f"{name}.msh")})
        for name in ("coarse", "fine")
    )
    assert fine.size > 2 * coarse.size
    found, true = (
        eigenmodes(effects.assemble(each, STEEL), 4).frequency for each in (coarse, fine)
    )
    np.testing.assert_allclose(found, true, rtol=5e-3)
    assert (found > true).all()  # a coarser mesh is stiffer
