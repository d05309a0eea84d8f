"""Frequencies of meshed bodies against published ones, and of a coarse mesh against a fine one."""

import runpy
from pathlib import Path

import numpy as np
import pytest
import skfem
from meshes import spaced, straight
from scipy.linalg import eigh

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


@pytest.mark.parametrize("kind", KINDS)
def test_a_free_square_block_has_the_mode_of_lame(kind):
    """u = (cos px sin py, -sin px cos py, 0), p = pi/a, leaves all faces free of stress, whatever
    the thickness, and w = sqrt(2) p sqrt(mu/rho). Three elements a side, two of second order, are
    too stiff, by less than the error of sampling a wave: (ph)^2/12, or (ph)^4/120.
    """
    first = kind in ("triangle", "quad", "tetra", "hexahedron", "wedge")
    cells = 3 if first else 2
    mesh = straight(kind, (1.0, 1.0, 0.4), (cells, cells, 1))
    if KINDS[kind].mesh is not type(mesh):
        mesh = KINDS[kind].mesh.from_mesh(mesh)
    made = spaced(mesh, kind, clamped=())
    term, (x, y) = effects.assemble(made, STEEL), np.pi * made.dof_location[:, :2].T
    along = [made.dof_axis == 0, made.dof_axis == 1]
    exact = np.select(along, [np.cos(x) * np.sin(y), -np.sin(x) * np.cos(y)], 0.0)
    mass = term.mass.toarray()
    squares, shapes = eigh(term.stiffness.toarray(), mass)
    found = np.sqrt(squares[np.abs(shapes.T @ mass @ exact).argmax()])
    closed = np.sqrt(2.0) * np.pi * np.sqrt(200.0e9 / 2.6 / 8000.0)
    wave = (np.pi / cells) ** 2
    assert 0.0 < found / closed - 1.0 < (wave / 12 if first else wave**2 / 120)


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
