"""Fits of a manifold against what they are made of, and its force map against the free body."""

import numpy as np
import pytest
from scipy.sparse import csr_matrix

from vibrom.latent.manifold_fit import Polynomials, fitted, symplectic_push
from vibrom.latent.polynomial import exponents, monomials

RNG = np.random.default_rng(0)
Y = RNG.uniform(-1.0, 1.0, (200, 2))
ONE = np.ones(len(Y))


def test_a_polynomial_is_found_from_its_values():
    powers = exponents(2, 0, 4)
    true = RNG.standard_normal((3, len(powers)))
    true[:, 0] = 0.0
    values = monomials(Y, powers) @ true.T
    np.testing.assert_allclose(fitted(Y, ONE, values, 4).coefficients, true, atol=1e-12)
    known = fitted(Y, ONE, values, 4, linear=true[:, 1:3])
    np.testing.assert_allclose(known.coefficients, true, atol=1e-12)
    raised = fitted(Y, ONE, values + 2.0, 4, constant=True)
    np.testing.assert_allclose(raised.coefficients[:, 0], 2.0, atol=1e-12)


def test_a_known_linear_part_stays():
    linear = np.array([[0.3, -2.0]])
    found = fitted(Y, ONE, np.sin(Y[:, :1]), 5, linear=linear)
    assert np.array_equal(found.coefficients[:, 1:3], linear)


def test_slopes_are_those_of_differences():
    found = Polynomials(RNG.standard_normal((2, 15)), exponents(2, 0, 4))

    def value(y):
        return monomials(y, found.powers) @ found.coefficients.T

    for axis in range(2):
        step = 1e-6 * np.eye(2)[axis]
        # Rounding over the step, 1e-16/1e-6, and the third derivative times its square.
        difference = (value(Y + step) - value(Y - step)) / 2e-6
        np.testing.assert_allclose(found.slope(Y, axis), difference, atol=1e-8)


@pytest.mark.parametrize("bent", [0.0, 0.3])
def test_a_load_moves_a_free_particle_on_a_manifold_by_its_work(bent):
    """A mass on the curve q = (y, b y^2), at speed y' along it: what a load adds to y'' is its part
    along the curve over the mass there, and it adds nothing to y'.
    """
    mass = csr_matrix(np.diag([2.0, 3.0]))
    powers = exponents(2, 0, 2)  # 1, y, y', y^2, y y', y'^2
    shape = Polynomials(np.array([[0, 1, 0, 0, 0, 0], [0, 0, 0, bent, 0, 0.0]]), powers)
    velocity = Polynomials(np.array([[0, 0, 1, 0, 0, 0], [0, 0, 0, 0, 2 * bent, 0.0]]), powers)
    found = symplectic_push(shape, velocity, mass, np.eye(2), Y)
    tangent = np.stack([np.ones(len(Y)), 2 * bent * Y[:, 0]], axis=1)
    expected = tangent / (tangent**2 @ mass.diagonal())[:, None]
    np.testing.assert_allclose(found[:, 1], expected, atol=1e-13)
    np.testing.assert_allclose(found[:, 0], 0.0, atol=1e-13)


def test_the_push_is_the_same_motion_in_other_coordinates():
    """y = (x, x') and y = (s, s') with x = s + s^3/10: dy/dt follows by the chain rule."""
    mass, powers = csr_matrix(np.diag([2.0, 3.0])), exponents(2, 0, 7)
    s, rate = Y.T
    x, slope = s + 0.1 * s**3, 1.0 + 0.3 * s**2
    old = np.stack([x, slope * rate], axis=1)

    def state(y):
        return (
            np.stack([y[:, 0], 0.2 * y[:, 0] ** 2], axis=1),
            np.stack([y[:, 1], 0.4 * y[:, 0] * y[:, 1]], axis=1),
        )

    ones = np.ones(len(Y))
    pushes = []
    for y in (old, Y):
        shape, velocity = (fitted(y, ones, part, 7) for part in state(old))
        assert np.array_equal(shape.powers, powers)
        pushes.append(symplectic_push(shape, velocity, mass, np.eye(2), y))
    bend = 0.6 * s * rate
    chain = np.stack(
        [
            slope[:, None] * pushes[1][:, 0],
            bend[:, None] * pushes[1][:, 0] + slope[:, None] * pushes[1][:, 1],
        ],
        axis=1,
    )
    np.testing.assert_allclose(chain, pushes[0], atol=1e-9)
