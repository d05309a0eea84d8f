"""The compiled kernels against scikit-fem's readable forms."""

import numpy as np
import pytest
import skfem
from scenes import UNDAMPED, body
from skfem.helpers import ddot, grad, identity, trace

from vibrom import effects
from vibrom.bodies import space

CASES = [
    ("bilinear", "stress"),
    ("bilinear", "strain"),
    ("quadratic", "stress"),
    ("serendipity", "strain"),
]


def built(element, plane):
    chosen = {**UNDAMPED, "elasticity": {**UNDAMPED["elasticity"], "plane": plane}}
    made = space.build(body(element=element, cells=[7, 2], height=0.1))
    return made, effects.assemble(made, chosen), chosen["elasticity"]


def oracle(made, elasticity, u):
    """Internal force of the St. Venant-Kirchhoff material on the free dofs [N], S = lambda tr(E) I
    + 2 mu E.
    """
    young, nu = elasticity["young_modulus"], elasticity["poisson_ratio"]
    mu = young / (2 * (1 + nu))
    first = (
        young * nu / (1 - nu**2)
        if elasticity["plane"] == "stress"
        else young * nu / ((1 + nu) * (1 - 2 * nu))
    )

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


def kernel_force(term, u, width):
    force = term.forces[0]
    q, f = np.repeat(u[:, None], width, axis=1), np.zeros((len(u), width))
    force.kernels(width)[0](q, np.zeros_like(q), force.dofs, force.table, f)
    return f


@pytest.mark.parametrize("element, plane", CASES)
@pytest.mark.parametrize("width", [1, 8])
def test_force_is_that_of_the_form(element, plane, width):
    made, term, elasticity = built(element, plane)
    u = 0.02 * np.random.default_rng(1).standard_normal(made.size)
    expected = oracle(made, elasticity, u)
    f = kernel_force(term, u, width) + (term.stiffness @ u)[:, None]
    # Rounding only: sums of some hundred products.
    assert np.abs(f - expected[:, None]).max() <= 1e-12 * np.abs(expected).max()


@pytest.mark.parametrize("element, plane", CASES)
def test_linear_stiffness_is_that_of_the_form(element, plane):
    made, term, elasticity = built(element, plane)
    u = 1e-9 * np.random.default_rng(2).standard_normal(made.size)
    expected = oracle(made, elasticity, u)
    # What the geometry adds is of relative size u/L, about 1e-8 here.
    assert np.abs(term.stiffness @ u - expected).max() <= 1e-6 * np.abs(expected).max()


def test_rigid_rotation_makes_no_force():
    made = space.build(body(cells=[7, 2], height=0.1, clamped=[]))
    term = effects.assemble(made, UNDAMPED)
    at, angle = made.dof_location, 1.1
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    u = ((at @ turn.T) - at)[np.arange(made.size), made.dof_axis]
    total = kernel_force(term, u, 1)[:, 0] + term.stiffness @ u
    assert np.abs(total).max() <= 1e-11 * np.abs(term.stiffness @ u).max()


def test_needs_elasticity_before_it():
    made = space.build(body(cells=[2, 1]))
    with pytest.raises(
        ValueError, match="effects.geometric_nonlinearity needs elastic.* list elasticity first"
    ):
        effects.assemble(made, {"inertia": {"density": 1.0}, "geometric_nonlinearity": {}})
