"""The map of reduced models: half a period of odd ones, kinks, and multipliers of a saddle."""

from dataclasses import replace

import numpy as np
import periodic_systems as systems
import pytest
from periodic_beam import periodic
from scipy.integrate import solve_ivp

from vibrom.latent.polynomial_kernel import polynomial_kernel
from vibrom.latent.table_kernel import tabulated
from vibrom.solvers.periodic import kinks
from vibrom.solvers.periodic.equations import from_rest
from vibrom.solvers.periodic.flow_map import odd
from vibrom.solvers.reduced.field import VectorField


@pytest.mark.parametrize("compiled", [True, False])
def test_half_a_period_and_a_sign_are_a_map_of_an_odd_model(compiled):
    """z(t + T/2) = -z(t): twice the half is the whole, and so are its derivative and the motion."""
    half = systems.reduced(**systems.TWO).return_map()
    half = half if compiled else replace(half, field=None)
    whole = replace(half, parts=1)
    assert half.parts == 2
    x = periodic(half, 0.75, 0.05, from_rest(half, 0.75, 0.05))
    once, full = half(x, 0.75, 0.05, phase=True), whole(x, 0.75, 0.05, phase=True)
    np.testing.assert_allclose(full.end, x, atol=1e-8)
    np.testing.assert_allclose(once.by_start @ once.by_start, full.by_start, atol=1e-6)
    assert once.in_phase == pytest.approx(full.in_phase, rel=1e-6)
    given = x[None], np.array([0.75]), np.array([0.05])
    shown = [flow.swings(*given)[0].displacement for flow in (half, whole)]
    np.testing.assert_allclose(*shown, atol=1e-7 * np.abs(shown[0]).max())
    away = 0.5 * x
    ends = [flow.after(away, 0.75, 0.05, 3) for flow in (half, whole)]
    np.testing.assert_allclose(*ends, atol=1e-7)


def test_a_model_that_is_not_odd_takes_whole_periods():
    """With a square in its spring, or an even drift; a force that is odd, as -z would pull back."""
    assert systems.in_a_well(0.3).return_map().parts == 1
    reach = np.ones(2)

    def drift(z):
        return np.stack([z[:, 1], -(z[:, 0] ** 3)], axis=1)

    def force(z):
        return np.stack([np.zeros(len(z)), np.cos(z[:, 0])], axis=1)

    assert odd(drift, force, reach)
    assert not odd(drift, lambda z: force(z) + 1e-3 * z, reach)
    assert not odd(lambda z: drift(z) + 1e-3 * z**2, force, reach)
    # Twice the range away, z^21 is a million times as large as the square within it.
    assert odd(lambda z: drift(z) - z**21, force, reach)
    assert not odd(lambda z: drift(z) - z**21 + 1e-3 * z**2, force, reach)
    # A rate of 1e-3 of the position's own is nothing beside that of the velocity.
    fast = np.array([1.0, 1e4])
    assert not odd(lambda z: drift(z) * fast + np.array([1e-3, 0.0]) * z**2, force, reach)


def test_kinks_are_found_with_the_fourth_power_of_the_step():
    """Of z = 1.25 sin(2 pi s), which passes 1 and -1 where sin is 0.8 and -0.8."""
    first = np.arcsin(0.8) / (2.0 * np.pi)
    exact = np.array([first, 0.5 - first, 0.5 + first, 1.0 - first])
    for number in (13, 26, 52):
        at = np.arange(number + 1) / number
        angle = 2.0 * np.pi * at[:, None]
        found = kinks.passed(1.25 * np.sin(angle), 2.5 * np.pi * np.cos(angle), at)
        # h^4/384 max |d4z| is the error of Hermite's cubic; its slope there is 1.5 pi.
        bound = 1.25 * (2.0 * np.pi) ** 4 / 384.0 / (1.5 * np.pi) / number**4
        np.testing.assert_allclose(found, exact, atol=1.2 * bound)
    assert not kinks.moved(exact, found) and kinks.moved(exact, found[1:])
    at = kinks.between(10, exact)
    assert at[0] == 0.0 and at[-1] == 1.0 and (np.diff(at) > 0.0).all() and len(at) < 24
    short = at[np.searchsorted(at, exact)] - at[np.searchsorted(at, exact) - 1]
    np.testing.assert_allclose(short, 2.0 * kinks.HALF)


def test_a_kink_of_the_force_costs_no_accuracy():
    """x'' + c x' + x + x^3 = b(x) a sin(Omega t), b = 1 - x/2 between -1 and 1, constant beyond:
    against SciPy in very short steps, and Liouville's product of the multipliers, exp(-c T). A step
    over a kink would leave some h^2, 1e-3 with so few, and as much of a multiplier.
    """
    damping, frequency, amplitude = 0.1, 1.4, 2.5
    model = systems.nonlinearly_damped(damping, 0.0, 0.0, 1.0, 2.0)
    powers, load = np.array([[0, 0], [1, 0]]), np.array([[0.0, 0.0], [1.0, -0.5]])
    force = tabulated(polynomial_kernel(np.ones(2), powers, load), 1.0)
    field = VectorField(model.rom.field(model.load).drift, force, np.array([1.0]))
    flow = replace(model.return_map(), field=field, parts=1)
    x, period = np.array([0.2, 0.1]), 2.0 * np.pi / frequency

    def slope(t, y):
        push = (1.0 - 0.5 * np.clip(y[0], -1.0, 1.0)) * amplitude * np.sin(frequency * t)
        return [y[1], push - y[0] - y[0] ** 3 - damping * y[1]]

    given = {"method": "DOP853", "rtol": 1e-10, "atol": 1e-12, "max_step": period / 4000}
    exact = solve_ivp(slope, (0.0, period), x * flow.reach, **given).y[:, -1]
    found = flow(x, frequency, amplitude)
    assert len(flow.steps.kinks) >= 2 and flow.steps.number <= 64
    np.testing.assert_allclose(found.end * flow.reach, exact, atol=2e-6)
    assert np.prod(found.multipliers).real == pytest.approx(np.exp(-damping * period), rel=1e-3)


def test_multipliers_of_a_saddle_that_motions_leave_by_a_factor_of_a_thousand():
    """mu = exp(lambda T), lambda^2 + c lambda - 1 = 0. First nudges are d = 1e-7 of the range Z,
    the second ones mu^(1/4) = 6 times less: differences are off by cubic (d Z mu)^2/8, 6e-9 and
    2e-10 of the derivative, and of the product of the two multipliers, a difference of terms of the
    size mu^2 = 1.2e6, by 7e-3 and 2e-4. Rounding, 1e-16/d, adds 1e-3 and 7e-3.
    """
    damping = 0.04
    rates = np.roots([1.0, damping, -1.0])
    period = 7.0 / rates.max()
    flow = replace(systems.saddle(damping, 1.0).return_map(), parts=1)
    for _ in range(2):
        found = np.sort(flow(np.zeros(2), 2 * np.pi / period, 0.0).multipliers)
        assert found[1] == pytest.approx(np.exp(7.0), rel=1e-6)
        assert np.prod(found) == pytest.approx(np.exp(-damping * period), abs=2e-2)
