"""Effects on bodies in space, against readable forms, closed forms and the plane."""

import numpy as np
import pytest
import skfem
from meshes import distorted
from scenes import BEAM, BENDING, LINE, body, quadratic_body
from skfem.helpers import dot, grad, identity

from vibrom import effects
from vibrom.bodies import space
from vibrom.solvers.full import static
from vibrom.solvers.full.modes import eigenmodes, linearised
from vibrom.term import SceneError

TIP = {"tip": {"at": [1.0, 0.02, 0.05], "direction": "y"}}
BLOCK = {"shape": "block", "element": "serendipity", "cells": [10, 1, 1], "probes": TIP}


def block(**changes):
    return space.build(body(**{**BLOCK, **changes}))


@pytest.mark.parametrize("kind", ["tetra", "tetra10", "hexahedron", "hexahedron27"])
def test_pressure_is_that_of_the_form(kind):
    """Nanson: the traction on the undeformed face is -pressure cof(F) N."""
    made = distorted(kind, curved=False)
    mesh, pressure = made.basis.mesh, 3.0
    facets = mesh.facets_satisfying(lambda x: x[0] > 0.85, boundaries_only=True)
    made = _with_boundary(made, "end", facets)
    term = effects.assemble(made, {"follower_load": {"edge": "end", "pressure": pressure}})
    rng = np.random.default_rng(0)
    u, v = 0.05 * rng.standard_normal((2, made.size))

    def kernel(q):
        f, (force,) = np.zeros((made.size, 1)), term.forces
        force.kernels(1)[0](q[:, None].copy(), np.zeros((made.size, 1)), force.dofs, force.table, f)
        return term.dead_load - f[:, 0]

    degree = 3 if kind in ("tetra", "hexahedron") else 5
    face = skfem.FacetBasis(made.basis.mesh, made.basis.elem, facets=facets, intorder=degree)

    @skfem.LinearForm
    def traction(test, w):
        deformed = np.moveaxis(grad(w["u"]) + identity(grad(w["u"])), (0, 1), (-2, -1))
        cofactor = np.linalg.det(deformed)[..., None, None] * np.linalg.inv(deformed)
        return dot(-pressure * np.einsum("...ji,j...->i...", cofactor, w.n), test)

    whole = np.zeros(made.basis.N)
    whole[made.free] = u
    expected = traction.assemble(face, u=face.interpolate(whole))[made.free]
    np.testing.assert_allclose(kernel(u), expected, atol=1e-13 * np.abs(expected).max())
    # Cubic in no displacement: central differences of a quadratic are exact.
    slope = 0.5 * (kernel(u + v) - kernel(u - v))
    tangent = static.Body(term).tangent(u) @ v
    np.testing.assert_allclose(tangent, -slope, atol=1e-12 * np.abs(slope).max() + 1e-14)


def _with_boundary(made, name, facets):
    from dataclasses import replace

    mesh = made.basis.mesh
    boundaries = {**mesh.boundaries, name: facets}
    basis = skfem.Basis(
        mesh.with_boundaries(boundaries), made.basis.elem, quadrature=made.basis.quadrature
    )
    return replace(made, basis=basis)


def test_pressure_all_around_moves_nothing():
    """A closed surface carries no resultant, deformed or not; each point pushes inwards."""
    made = distorted("tetra10", clamped=())
    made = _with_boundary(made, "all", made.basis.mesh.boundary_facets())
    term = effects.assemble(made, {"follower_load": {"edge": "all", "pressure": 2.0}})
    u = 0.05 * np.random.default_rng(1).standard_normal((made.size, 1))
    f, (force,) = np.zeros_like(u), term.forces
    force.kernels(1)[0](u, 0 * u, force.dofs, force.table, f)
    for load in (term.dead_load, term.dead_load - f[:, 0]):
        sums = np.bincount(made.dof_axis, load)
        # The quadrature of curved faces is exact for degree 5, as their normals are of degree 2.
        assert np.abs(sums).max() <= 1e-12 * np.abs(load).sum()
    # Work in a growth of the body is -pressure times the change of volume.
    growth = made.dof_location[np.arange(made.size), made.dof_axis]
    volume = made.mass.dx.sum()
    assert term.dead_load @ growth == pytest.approx(-2.0 * 3.0 * volume, rel=1e-12)


def test_a_shear_has_no_direction_on_a_face():
    with pytest.raises(SceneError, match="effects.follower_load.shear = 1 has no direction"):
        effects.assemble(block(), {"follower_load": {"edge": "right", "shear": 1.0}})


def test_cantilever_in_space_is_the_beam_and_the_plane_one():
    """Without Poisson's ratio: frequencies of bending about both axes, of torsion and of stretching
    against beam theory, and of bending in the plane against plane stress on the same mesh.
    """
    made, plane = block(), space.build(body(cells=[10, 1], element="serendipity"))
    solid, flat = (effects.assemble(each, BEAM) for each in (made, plane))
    found = eigenmodes(solid, 12).frequency
    in_plane = eigenmodes(flat, 3).frequency
    # Displacements of the plane body are among those of the solid one, and nothing couples them.
    # Rounding of axial stiffness moves bending by some 1e-8 at slenderness 50.
    for frequency in in_plane:
        assert np.abs(found / frequency - 1).min() < 1e-7
    upright = np.sqrt(BENDING / LINE)
    # Euler and Bernoulli, along y and along z, which is 2.5 times as stiff; ten elements are a
    # part in a thousand too stiff, and shear takes some parts of the second one, of slenderness 20.
    assert found[0] == pytest.approx(1.8751**2 * upright, rel=2e-3)
    assert np.abs(found / (1.8751**2 * 2.5 * upright) - 1).min() < 5e-3
    speed = np.sqrt(104.0e9 / 440.0)
    # Torsion: pi/2 c sqrt(J/I_p), Saint-Venant's J = 0.249 w h^3 of a cross section 2.5 : 1.
    shear, polar = speed / np.sqrt(2), (0.05**2 + 0.02**2) / 12
    torsion = 0.5 * np.pi * shear * np.sqrt(0.249 * 0.05 * 0.02**3 / (0.05 * 0.02 * polar))
    assert np.abs(found / torsion - 1).min() < 0.02  # warping is held at the clamp
    stretched = eigenmodes(solid, 20).frequency
    assert np.abs(stretched / (0.5 * np.pi * speed) - 1).min() < 1e-3


def test_weight_base_motion_and_masses_in_space():
    made = block()
    weight = {"x": 0.0, "y": 0.0, "z": -9.81}
    term = effects.assemble(made, {**BEAM, "gravity": weight, "base_motion": {"direction": "z"}})
    rest, _ = linearised(term)
    at, axis = made.dof_location, made.dof_axis
    tip = np.flatnonzero((np.abs(at - [1.0, 0.02, 0.05]).max(axis=1) < 1e-9) & (axis == 2))[0]
    stiffer = BENDING * (0.05 / 0.02) ** 2
    # w = m g L^4/(8 EI); shear adds 4 (h/L)^2/10 = 0.1 %.
    assert rest[tip] == pytest.approx(-LINE * 9.81 / (8 * stiffer), rel=3e-3)
    # A falling support is a weight that points up.
    np.testing.assert_allclose(term.dead_load, 9.81 * term.load, atol=1e-15)
    heavy = effects.assemble(made, {**BEAM, "tip_mass": {"at": [1.0, 0.02, 0.05], "mass": 3.0}})
    added = heavy.mass - term.mass
    assert added.diagonal().sum() == pytest.approx(9.0)


def test_a_plane_body_has_no_weight_across_it():
    plane = space.build(quadratic_body(cells=[2, 1]))
    with pytest.raises(SceneError, match="effects.gravity.z = 1 pulls out of the plane"):
        effects.assemble(plane, {**BEAM, "gravity": {"z": 1.0}})
    with pytest.raises(SceneError, match="base_motion.direction = 'z' is not in the body"):
        effects.assemble(plane, {**BEAM, "base_motion": {"direction": "z"}})
