"""Dissipative fits: least squares under inequalities, and the bounds that prove them."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import minimize

from vibrom.latent.dissipative import (
    MARGIN,
    RADII,
    RAYS,
    conditions,
    constrained_least_squares,
    fit_dissipative,
)
from vibrom.latent.dissipative_proof import bounds
from vibrom.latent.polynomial import exponents, monomials

RNG = np.random.default_rng(0)


def by_a_general_optimiser(matrix, target, rows, bounds):
    return minimize(
        lambda x: np.sum((matrix @ x - target) ** 2),
        np.zeros(5),
        method="SLSQP",
        options={"ftol": 1e-14, "maxiter": 500},
        jac=lambda x: 2 * matrix.T @ (matrix @ x - target),
        constraints={"type": "ineq", "fun": lambda x: bounds - rows @ x, "jac": lambda x: -rows},
    )


def test_constrained_least_squares_against_a_general_optimiser():
    for seed in range(5):
        rng = np.random.default_rng(seed)
        matrix, target, rows = (
            rng.standard_normal((30, 5)),
            rng.standard_normal(30),
            rng.standard_normal((12, 5)),
        )
        bounds = rows @ rng.standard_normal(5) + 0.1  # some x obeys
        x = constrained_least_squares(matrix, target, rows, bounds)
        other = by_a_general_optimiser(matrix, target, rows, bounds)
        assert (rows @ x <= bounds + 1e-10).all() and (rows @ x > bounds - 1e-10).any()
        np.testing.assert_allclose(x, other.x, atol=1e-6)  # SLSQP stops at 1e-14 in the square


@pytest.mark.parametrize("order", [1, 3, 9])
def test_the_bounds_of_a_fit_are_bounds_and_close_ones(order):
    """Of any polynomials, on a grid of other points and beyond the range. Between the points of the
    bound a ray's polynomial rises by less than (h/2)^2/2 of its second derivative, and the mean of
    the bound's own points by 1/cos(pi n/2048) - 1 < 2e-4 of its half range.
    """
    powers = exponents(2, 1, order)
    rows, limits = conditions(powers, 1001, 21)
    half = len(rows) // 2
    for _ in range(2):
        fit = RNG.standard_normal(len(powers))
        sampled = rows @ fit - limits
        sampled[half:] -= MARGIN
        size = np.abs(rows).max(axis=0) @ np.abs(fit)
        for bound, part in zip(bounds(fit, powers), (sampled[:half], sampled[half:])):
            assert part.max() - 1e-12 * size <= bound <= part.max() + 1e-3 * size


@pytest.mark.parametrize("order", [5, 7, 9])
def test_a_dissipative_fit_is_damped_between_the_points_where_that_is_imposed(order):
    """An oscillator whose damping touches zero at |z| = 0.63: polynomials undershoot it. On a grid
    of other points, eleven times as fine as the first one.
    """

    def rate(_, y):
        return [y[1], -y[0] - 0.3 * y[0] ** 3 - 0.3 * (y[0] ** 2 - 0.4) ** 2 * y[1]]

    run = solve_ivp(
        rate, (0.0, 40.0), [1.0, 0.0], t_eval=np.linspace(0.0, 40.0, 801), rtol=1e-9, atol=1e-9
    )
    z, velocity = run.y
    motion = np.stack([z, velocity, rate(0.0, run.y)[1]])[:, :, None]
    reach, powers = np.abs(run.y).max(axis=1), exponents(2, 1, order)
    unit = reach[1] ** 2 / reach[0]
    fitted = fit_dissipative(motion, reach, reach, order) / unit
    rows, bounds = conditions(powers, 1001, 101)
    assert (rows @ fitted - bounds).max() < 0.0
    library = monomials(np.stack([z, velocity], axis=1) / reach, powers)
    first = constrained_least_squares(
        library, motion[2, :, 0] / unit, *conditions(powers, RAYS, RADII)
    )
    assert (rows @ first - bounds).max() > 1e-5  # what the first points alone leave open
    # and the price of the others is small
    off = [np.linalg.norm(library @ x - motion[2, :, 0] / unit) for x in (fitted, first)]
    assert off[0] < 1.2 * off[1]
