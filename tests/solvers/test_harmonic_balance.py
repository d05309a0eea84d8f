"""Harmonic balance: its first harmonic in closed form, the same curves as by shooting, and folds
of two masses by a third way, collocation of the variational equation by SciPy.
"""

import numpy as np
import periodic_systems as systems
import pytest
from scipy.integrate import solve_bvp

from vibrom.solvers.periodic.continuation import Pace, at
from vibrom.solvers.periodic.equations import in_frequency
from vibrom.solvers.periodic.harmonic_balance import HarmonicBalance
from vibrom.solvers.periodic.response import Span, response
from vibrom.solvers.periodic.stability import Kind

FORCE = 0.06


def curve(flow, amplitude, lowest, highest):
    """All branches between two frequencies."""
    pace = Pace(0.1 * (highest - lowest), newton=True)
    return response(in_frequency(flow, amplitude), Span(lowest, highest, 300, 1e-3), pace)


def folds(found):
    """Where the main folds are, in the order of the branch."""
    return np.array([item.orbit.p for item in found if item.orbit.kind == Kind.FOLD])


def test_one_harmonic_of_duffing_is_its_closed_form():
    """[(1 - w^2 + 3 A^2/4)^2 + (c w)^2] A^2 = f^2, exactly, as cubes are balanced exactly."""
    flow = systems.reduced(**systems.DUFFING).return_map()
    found = curve(HarmonicBalance(flow, 1), 0.1, 0.7, 1.8)
    x = np.array([item.orbit.point.x for item in found]).reshape(-1, 3, 2)[:, :, 0]
    a, w = flow.reach[0] * np.hypot(x[:, 1], x[:, 2]), np.array([item.orbit.p for item in found])
    assert a.max() > 1.0 and len(folds(found)) == 2
    c = systems.DUFFING["damping"]
    force = a * np.hypot(1.0 - w**2 + 0.75 * a**2, c * w)
    # The last correction, 1e-5, is still made: some squares of it are left.
    np.testing.assert_allclose(force, 0.1, rtol=1e-8)
    np.testing.assert_allclose(x[:, 0], 0.0, atol=1e-9)


@pytest.fixture(scope="module")
def two():
    """Two masses: the flow, and their curve by shooting."""
    flow = systems.reduced(**systems.TWO).return_map()
    return flow, curve(flow, FORCE, 0.6, 1.0)


def test_the_curve_is_that_by_shooting_and_says_how_many_harmonics_it_takes(two):
    flow, shot = two
    missed, errors = [], []
    for harmonics in (3, 5, 7):
        found = curve(HarmonicBalance(flow, harmonics), FORCE, 0.6, 1.0)
        missed.append(max(item.orbit.point.value.details.open for item in found))
        errors.append(np.abs(folds(found) / folds(shot) - 1.0).max())
    # Odd harmonics of a cubic spring fall by the ratio of its force to the inertia, here a tenth.
    assert all(later < 0.2 * sooner for sooner, later in zip(missed, missed[1:]))
    # By shooting, steps with an error of 1e-6 leave less than a tenth of that.
    assert errors[0] < 1e-4 and errors[2] < 1e-7
    top, balanced = (
        max(item.swing.displacement[0].max() for item in all_) for all_ in (shot, found)
    )
    # Each has points of its own about the peak.
    assert balanced == pytest.approx(top, rel=1e-4)


def test_multipliers_are_those_of_the_same_motion_by_shooting(two):
    flow, shot = two
    balance = HarmonicBalance(flow, 9)
    steep = [item for item in shot if abs(item.orbit.point.tangent[-1]) > 1e-3]
    for item in steep[::12]:  # near a fold the frequency does not tell which motion
        x, omega = item.orbit.point.x, item.orbit.p
        start = balance.of_point(x, omega, FORCE)
        point = at(in_frequency(balance, FORCE), start, omega, Pace(0.04, newton=True))
        ours = np.sort(np.abs(point.value.details.multipliers))
        theirs = np.sort(np.abs(item.multipliers)) ** flow.parts
        np.testing.assert_allclose(ours, theirs, rtol=1e-5)
        np.testing.assert_allclose(point.value.details.start, x, atol=1e-5)


def test_two_masses_fold_where_collocation_has_it(two):
    """z' = f(z, t), y' = f_z y, both periodic, the integral of |y|^2 one: at a fold of the curve a
    change y of the motion is periodic too. By SciPy's collocation of fourth order.
    """
    flow, shot = two
    system = systems.TWO
    inverse, c = np.linalg.inv(system["mass"]), system["damping"]
    load, cubic = np.array(system["load"]), np.array(system["cubic"])

    def slope(s, z, p):
        q, v, dq, dv = z[:2], z[2:4], z[4:6], z[6:8]
        wave = FORCE * load[:, None] * np.sin(2 * np.pi * s)
        pull = system["stiffness"] @ q + cubic[:, None] * q**3 - wave
        bend = system["stiffness"] @ dq + 3 * cubic[:, None] * q**2 * dq
        rates = [v, -inverse @ pull - c * v, dv, -inverse @ bend - c * dv, [np.sum(dq**2, axis=0)]]
        return 2 * np.pi / p[0] * np.vstack(rates)

    def ends(start, end, p):
        return np.append(end[:8] - start[:8], [start[8], end[8] - 2 * np.pi / p[0]])

    for item in (item for item in shot if item.orbit.kind == Kind.FOLD):
        omega, s = item.orbit.p, np.linspace(0.0, 1.0, 129)
        states = flow.states(item.orbit.point.x, omega, FORCE)
        nearby = flow.states(
            item.orbit.point.x + 1e-3 * item.orbit.point.tangent[:-1], omega, FORCE
        )
        change = nearby - states
        change /= np.sqrt(np.mean(np.sum(change[:, :2] ** 2, axis=1)))
        closed = np.hstack([states, change])[np.append(np.arange(128), 0)].T
        guess = np.vstack([closed, 2 * np.pi / omega * s])
        found = solve_bvp(slope, ends, s, guess, [0.999 * omega], tol=1e-7, max_nodes=20000)
        assert found.success
        # Relative residuals of 1e-7 in both.
        assert found.p[0] == pytest.approx(omega, rel=1e-6)
