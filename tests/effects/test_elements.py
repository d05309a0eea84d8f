"""Every kind of element, in the plane and in space: the compiled kernels against scikit-fem's
readable forms, on distorted elements with the same quadrature.
"""

import numpy as np
import pytest
import skfem
from meshes import distorted
from scenes import UNDAMPED
from skfem.helpers import ddot, grad, identity, trace

from vibrom import effects
from vibrom.bodies.elements import KINDS
from vibrom.solvers.full.tangent import Tangent

ELASTICITY = {"young_modulus": 104.0e9, "poisson_ratio": 0.3}
CASES = [
    *((kind, "stress") for kind in KINDS),
    ("triangle", "strain"),
    ("triangle6", "strain"),
    ("quad9", "strain"),
]


def built(kind, plane="stress", clamped=("left",), curved=True):
    made = distorted(kind, clamped, curved)
    listed = {**UNDAMPED, "elasticity": {**ELASTICITY, "plane": plane}}
    return made, effects.assemble(made, listed)


def lame(made, plane):
    young, nu = ELASTICITY["young_modulus"], ELASTICITY["poisson_ratio"]
    thin = made.dimension == 2 and plane == "stress"
    first = young * nu / ((1 - nu**2) if thin else (1 + nu) * (1 - 2 * nu))
    return first, young / (2 * (1 + nu))


def oracle(made, plane, u):
    """Internal force of the St. Venant-Kirchhoff material on the free dofs [N], S = lambda tr(E) I
    + 2 mu E.
    """
    first, mu = lame(made, plane)

    @skfem.LinearForm
    def internal(v, w):
        h = grad(w["u"])
        f = h + identity(h)
        strain = 0.5 * (np.einsum("ki...,kj...->ij...", f, f) - identity(h))
        stress = first * trace(strain) * identity(h) + 2 * mu * strain
        return made.thickness * ddot(np.einsum("ik...,kj...->ij...", f, stress), grad(v))

    whole = np.zeros(made.basis.N)
    whole[made.free] = u
    return internal.assemble(made.basis, u=made.basis.interpolate(whole))[made.free]


def internal(term, u, width=1):
    force = term.forces[0]
    q, f = np.repeat(u[:, None], width, axis=1), np.zeros((len(u), width))
    force.kernels(width)[0](q, np.zeros_like(q), force.dofs, force.table, f)
    return f + (term.stiffness @ u)[:, None]


@pytest.mark.parametrize("kind, plane", CASES)
def test_force_is_that_of_the_form(kind, plane):
    made, term = built(kind, plane)
    u = 0.1 * np.random.default_rng(1).standard_normal(made.size)
    expected = oracle(made, plane, u)
    found = internal(term, u)
    # Rounding only: sums of some thousand products.
    assert np.abs(found - expected[:, None]).max() <= 1e-12 * np.abs(expected).max()


@pytest.mark.parametrize("kind", ["triangle6", "tetra", "hexahedron"])
def test_states_side_by_side_are_each_as_alone(kind):
    made, term = built(kind)
    u = 0.1 * np.random.default_rng(1).standard_normal(made.size)
    expected = internal(term, u)
    assert np.abs(internal(term, u, 8) - expected).max() <= 1e-12 * np.abs(expected).max()


@pytest.mark.parametrize("kind", KINDS)
def test_tangent_is_the_derivative_of_the_force(kind):
    """The force is cubic, so that central differences with Richardson's extrapolation are exact."""
    made, term = built(kind)
    rng = np.random.default_rng(2)
    q, along = 0.1 * rng.standard_normal(made.size), 0.1 * rng.standard_normal(made.size)
    tangent = Tangent(term, 0.0, 0.0, 1.0).at(q[:, None].copy(), np.zeros((made.size, 1)))
    f = {k: internal(term, q + k * along)[:, 0] for k in (-2, -1, 1, 2)}
    slope = (8 * (f[1] - f[-1]) - (f[2] - f[-2])) / 12
    # Rounding of the forces, which are up to some times as large as their differences.
    np.testing.assert_allclose(tangent @ along, slope, atol=1e-12 * np.abs(f[2]).max())
    assert abs(tangent - tangent.T).max() <= 1e-14 * abs(tangent).max()


@pytest.mark.parametrize("kind", KINDS)
def test_patches_stretch_evenly_and_rigid_motion_makes_no_force(kind):
    """A linear displacement of a distorted mesh strains it evenly, so that nodes inside are in
    equilibrium; a rotation by 63 degrees strains nothing. Both are exact in isoparametric elements,
    but in curved tetrahedra, which need a quadrature of degree 3: four points have 2.
    """
    made, term = built(kind, clamped=(), curved=kind != "tetra10")
    rng, dim = np.random.default_rng(4), made.dimension
    at, axis = made.dof_location, made.dof_axis
    stretch = 0.1 * rng.standard_normal((dim, dim))
    u = (at @ stretch.T)[np.arange(made.size), axis]
    f, load = internal(term, u)[:, 0], np.zeros(dim)
    surface = made.basis.get_dofs(made.basis.mesh.boundary_facets()).all()
    inside = ~np.isin(made.free, surface)
    size = np.abs(f).max()
    if inside.any():
        assert np.abs(f[inside]).max() <= 1e-12 * size
    np.add.at(load, axis, f)
    assert np.abs(load).max() <= 1e-12 * size
    first, mu = lame(made, "stress")
    deformed = np.eye(dim) + stretch
    strain = 0.5 * (deformed.T @ deformed - np.eye(dim))
    stress = first * np.trace(strain) * np.eye(dim) + 2 * mu * strain
    volume = made.thickness * made.basis.dx.sum()
    # f . u = int P : H dV  of the even stress P = F S.
    assert f @ u == pytest.approx(volume * np.sum((deformed @ stress) * stretch), rel=1e-12)
    angle, turn = 1.1, np.eye(dim)
    turn[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    u = ((at @ turn.T) - at)[np.arange(made.size), axis]
    assert np.abs(internal(term, u)).max() <= 1e-11 * np.abs(term.stiffness @ u).max()


@pytest.mark.parametrize("kind", KINDS)
def test_mass_and_weight(kind):
    """The mass moved along each axis is density times volume; it is positive definite."""
    made, term = built(kind, clamped=())
    volume = 440.0 * made.thickness * (made.mass or made.basis).dx.sum()
    for direction in range(made.dimension):
        rigid = (made.dof_axis == direction).astype(float)
        assert rigid @ term.mass @ rigid == pytest.approx(volume, rel=1e-12)
    assert np.linalg.eigvalsh(term.mass.toarray()).min() > 0


@pytest.mark.parametrize("kind", KINDS)
def test_rigid_modes_are_all_that_costs_no_energy(kind):
    """3 in the plane, 6 in space: the quadrature leaves no others."""
    made, term = built(kind, clamped=())
    values = np.linalg.eigvalsh(term.stiffness.toarray())
    rigid = 3 if made.dimension == 2 else 6
    assert np.abs(values[:rigid]).max() <= 1e-12 * values[-1]
    assert values[rigid] > 1e-6 * values[-1]


def test_nonlinearity_needs_elasticity_before_it():
    with pytest.raises(
        ValueError, match="effects.geometric_nonlinearity needs elastic.* list elasticity first"
    ):
        listed = {"inertia": {"density": 1.0}, "geometric_nonlinearity": {}}
        effects.assemble(distorted("quad"), listed)
