"""The map of reduced models: half a period of odd ones, and multipliers of a saddle."""

from dataclasses import replace

import numpy as np
import periodic_systems as systems
import pytest
from periodic_beam import periodic

from vibrom.solvers.periodic.equations import from_rest
from vibrom.solvers.periodic.flow_map import odd


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
