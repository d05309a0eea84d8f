"""Whole response curves: folds against the averaged equation, against sweeps and against a second
integrator; a pitchfork at a place that another integration gives.
"""

import numpy as np
import periodic_systems as systems
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from vibrom.artefacts.outcome import Outcome
from vibrom.solvers.periodic.continuation import Pace
from vibrom.solvers.periodic.equations import in_amplitude, in_frequency
from vibrom.solvers.periodic.response import Span, response
from vibrom.solvers.periodic.stability import WILD, Kind


def curve(flow, amplitude, lowest, highest, **pace):
    """All branches between two frequencies."""
    pace = Pace(0.1 * (highest - lowest), newton=flow.free, **pace)
    return response(in_frequency(flow, amplitude), Span(lowest, highest, 300, 1e-3), pace)


def folds(found):
    """Where the main folds are, in the order of the branch."""
    return np.array([item.orbit.p for item in found if item.orbit.kind == Kind.FOLD])


def averaged_folds(damping, force):
    """Of x'' + c x' + x + x^3 = f sin(Omega t), by averaging: with Omega = 1 + s the amplitude a
    obeys  (c a/2)^2 + (a s - 3 a^3/8)^2 = (f/2)^2,  and folds where ds/da = 0.
    """
    places = []
    for side in (-1.0, 1.0):  # left and right of the backbone s = 3 a^2/8

        def slope(a, side=side):
            root = np.sqrt((force / (2 * a)) ** 2 - (damping / 2) ** 2)
            return 0.75 * a - side * force**2 / (4 * a**3 * root)

        grid = force / damping * (1.0 - np.geomspace(1e-9, 0.9, 4000))
        signs = np.sign(slope(grid))
        for k in np.flatnonzero(signs[1:] != signs[:-1]):
            a = brentq(slope, grid[k], grid[k + 1])
            root = np.sqrt((force / (2 * a)) ** 2 - (damping / 2) ** 2)
            places.append(1.0 + 3 * a**2 / 8 + side * root)
    return np.sort(places)


def test_duffings_folds_tend_to_those_of_the_averaged_equation():
    """c = 2 e, f = 6 e sqrt(e): detunings are of order e, and what averaging neglects e^2."""
    errors = []
    for small in (0.02, 0.01, 0.005):
        system = systems.DUFFING | {"damping": 2 * small}
        force = 6.0 * small**1.5
        expected = averaged_folds(2 * small, force)
        flow = systems.reduced(**system, reach=1.0).return_map()
        found = np.sort(folds(curve(flow, force, 1 - 4 * small, 1 + 8 * small)))
        assert len(found) == len(expected) == 2
        errors.append(np.abs(found - expected).max() / small)
    assert errors[-1] < 0.15
    # An error of order e^2 in a detuning of order e halves with e.
    assert errors[1] / errors[2] == pytest.approx(2.0, abs=0.5)
    assert errors[0] / errors[1] == pytest.approx(2.0, abs=0.5)


def test_duffings_folds_in_the_forcing_tend_to_those_of_the_averaged_equation():
    """At one detuning s of order e the same equation gives f(a), and folds where df/da = 0:
    c^2/4 + (s - 3 a^2/8)(s - 9 a^2/8) = 0, a quadratic equation of a^2.
    """
    errors = []
    for small in (0.02, 0.01, 0.005):
        damping, detuning = 2 * small, 5 * small
        square = np.roots([27 / 64, -1.5 * detuning, detuning**2 + damping**2 / 4])
        expected = 2 * np.sqrt(square * (damping**2 / 4 + (detuning - 3 * square / 8) ** 2))
        system = systems.DUFFING | {"damping": damping}
        flow = systems.reduced(**system, reach=1.0).return_map()
        largest = 2 * expected.max()
        span, pace = Span(0.02 * largest, largest, 150, 1e-6), Pace(largest, newton=True)
        found = np.sort(folds(response(in_amplitude(flow, 1.0 + detuning), span, pace)))
        errors.append(np.abs(found / np.sort(expected) - 1.0).max())
    assert errors[-1] < 0.05
    assert errors[1] / errors[2] == pytest.approx(2.0, abs=0.5)
    assert errors[0] / errors[1] == pytest.approx(2.0, abs=0.5)


def test_duffing_jumps_at_the_published_frequencies():
    """Of x'' + 2 z x' + x + s x^3 = cos(Omega t), lightly damped, by harmonic balance (Brennan,
    Kovacic, Carrella, Waters, J. Sound Vib. 318 (2008) 1250): up at Omega^2 = 1 + (3/2)^(4/3)
    s^(1/3), down at 2 Omega^2 = 1 + (1 + 3 s/(4 z^2))^(1/2).
    """
    ratio, cubic = 0.006, 1e-4
    system = systems.DUFFING | {"damping": 2 * ratio, "cubic": [cubic]}
    found = folds(curve(systems.reduced(**system, reach=90.0).return_map(), 1.0, 0.9, 1.3))
    up = np.sqrt(1.0 + 1.5 ** (4 / 3) * cubic ** (1 / 3))
    down = np.sqrt(0.5 + 0.5 * np.sqrt(1.0 + 0.75 * cubic / ratio**2))
    # Left out is damping where it jumps up, z^2 s^(-1/3) = 8e-4, and at the peak the third
    # harmonic, of which (s A^2)^2/200 = 1e-3 comes back.
    np.testing.assert_allclose(np.sort(found), [up, down], rtol=2e-3)


@pytest.fixture(scope="module")
def two():
    """The curve of two masses, by the full order and by the exact reduced model."""
    models = systems.full_order(**systems.TWO), systems.reduced(**systems.TWO)
    flows = [model.return_map() for model in models]
    return flows, [curve(flow, 0.06, 0.6, 1.0) for flow in flows]


def test_both_kinds_of_model_fold_at_the_same_places(two):
    _, found = two
    full, reduced = map(folds, found)
    assert len(full) == len(reduced) == 2
    # (omega h)^2/24 of the frequency is lost in the steps of the full order, 1e-5.
    np.testing.assert_allclose(full, reduced, rtol=3e-5)
    for items in found:
        assert items[-1].orbit.kind == Kind.END and items[-1].orbit.outcome == Outcome.OK
        assert {item.branch for item in items} == {0}


def test_stability_changes_at_the_folds_alone(two):
    _, found = two
    for items in found:
        marks = np.cumsum([item.orbit.kind == Kind.FOLD for item in items])
        stable = np.array([np.abs(item.multipliers).max() < 1.0 for item in items])
        regular = np.array([item.orbit.kind != Kind.FOLD for item in items])
        np.testing.assert_array_equal(stable[regular], (marks % 2 == 0)[regular])


def test_stable_motions_are_where_time_marching_stays_and_unstable_ones_are_left(two):
    """400 periods of the map itself; a stable motion is kept to 1e-5, an unstable one is not."""
    flows, found = two
    for flow, items in zip(flows, found):
        for stable in (True, False):
            chosen = [
                item.orbit
                for item in items
                if (
                    np.abs(item.multipliers).max() < 0.95
                    if stable
                    else np.abs(item.multipliers).max() > 1.02
                )
            ]
            for orbit in chosen[:: max(len(chosen) // 3, 1)]:
                x = orbit.point.x
                ended = flow.after(x * (1.0 + 1e-4), orbit.p, 0.06, 400)
                apart = np.linalg.norm(ended - x) / np.linalg.norm(x)
                assert apart < 1e-5 if stable else apart > 1e-2


def test_folds_are_where_a_slow_sweep_jumps(two):
    """Beyond the upper fold the upper motion is gone, before it is there; below likewise."""
    (flow, _), (found, _) = two
    high, low = folds(found)
    places = [number for number, item in enumerate(found) if item.orbit.kind == Kind.FOLD]
    for place, inside in zip(places, (-1.0, 1.0)):
        orbit = found[place].orbit
        for side in (inside, -inside):
            x = flow.after(orbit.point.x, orbit.p * (1.0 + side * 2e-3), 0.06, 300)
            near = np.linalg.norm(x - orbit.point.x) / np.linalg.norm(x)
            assert (near < 0.4) == (side == inside)
    assert high > low


def test_a_curve_in_the_amplitude_folds_too(two):
    """An S-curve between the folds: one motion at a small forcing, three, one at a large one."""
    flow = two[0][1]
    high, low = folds(two[1][1])
    middle = 0.5 * (high + low)
    pace = Pace(0.03, newton=True)
    found = response(in_amplitude(flow, middle), Span(0.005, 0.2, 300, 1e-6), pace)
    ends = folds(found)
    assert len(ends) == 2 and ends[1] < 0.06 < ends[0]
    last = found[-1].orbit
    assert last.outcome == Outcome.OK and last.p == pytest.approx(0.2)


def test_two_equal_oscillators_lose_their_symmetry_where_theory_says():
    """Coupled by a spring and driven alike they move as one Duffing oscillator x(t), until its
    difference y'' + c y' + (1 + 2 k + 3 x^2) y = 0 grows: integrated apart from our maps.
    """
    coupling, damping, force = 0.15, 0.05, 0.45
    pair = {
        "mass": np.eye(2),
        "stiffness": np.array([[1.0 + coupling, -coupling], [-coupling, 1.0 + coupling]]),
        "load": [1.0, 1.0],
        "cubic": [1.0, 1.0],
        "damping": damping,
    }
    flow = systems.reduced(**pair).return_map()
    found = curve(flow, force, 0.5, 2.6)
    named = [
        item.orbit for item in found if item.orbit.kind in (Kind.PITCHFORK, Kind.PERIOD_DOUBLING)
    ]
    assert named

    def growth(orbit):
        """Multipliers of the difference along this motion."""
        x, _, v, _ = flow.state(orbit.point.x)

        def slope(t, y):
            drive = force * np.sin(orbit.p * t)
            stiffness = 1.0 + 2.0 * coupling + 3.0 * y[0] ** 2
            own = [y[1], -y[0] - y[0] ** 3 - damping * y[1] + drive]
            return [
                *own,
                y[3],
                -damping * y[3] - stiffness * y[2],
                y[5],
                -damping * y[5] - stiffness * y[4],
            ]

        end = solve_ivp(
            slope, (0, 2 * np.pi / orbit.p), [x, v, 1, 0, 0, 1], rtol=1e-10, atol=1e-12
        ).y[:, -1]
        np.testing.assert_allclose(end[:2], [x, v], atol=1e-6)
        return np.linalg.eigvals(end[2:].reshape(2, 2).T)

    for orbit in named:
        values = growth(orbit)
        sign = 1.0 if orbit.kind == Kind.PITCHFORK else -1.0
        assert np.abs(values - sign).min() < 2e-3


def test_a_branch_ends_where_disturbances_grow_too_much_in_a_period():
    """At a saddle that is little disturbed they grow by exp(lambda 2 pi/Omega)."""
    damping = 0.1
    rate = np.roots([1.0, damping, -1.0]).max()
    last = 2 * np.pi * rate / np.log(WILD)
    found = curve(systems.saddle(damping, 1.0).return_map(), 1e-3, last - 0.1, last + 0.5)
    below, above = ([item for item in found if item.branch == number] for number in (0, 1))
    assert len(below) == 2  # the start and one more
    assert above[-2].orbit.p > last >= above[-1].orbit.p
    assert above[-1].orbit.outcome == below[-1].orbit.outcome == Outcome.LOST
    assert len(above) > 3


def test_a_snap_through_is_followed_past_motions_that_are_left_five_hundredfold():
    """Nine folds from small motions in one well to small motions in the other one, at x = -2."""
    damping, frequency, top = 0.5, 0.45, 0.8
    flow = systems.in_a_well(damping).return_map()
    span, pace = Span(0.02 * top, top, 400, 1e-3), Pace(0.5 * top, turn=0.2, newton=True)
    found = response(in_amplitude(flow, frequency), span, pace)
    last = found[-1]
    assert last.orbit.outcome == Outcome.OK and last.orbit.p == pytest.approx(0.02 * top)
    assert np.abs(last.swing.displacement + 2.0).max() < 0.02 and np.abs(last.multipliers).max() < 1
    largest = np.array([np.abs(item.multipliers).max() for item in found])
    worst = found[int(largest.argmax())]
    assert len(folds(found)) == 9

    def slope(t, y):
        drive = worst.orbit.p * np.sin(frequency * t)
        pull = -y[0] * (y[0] + 1.0) * (y[0] + 2.0) - damping * y[1] + drive
        turned = -(2.0 + 6.0 * y[0] + 3.0 * y[0] ** 2)
        beside = (y[3], turned * y[2] - damping * y[3], y[5], turned * y[4] - damping * y[5])
        return [y[1], pull, *beside]

    start = [*flow.state(worst.orbit.point.x), 1, 0, 0, 1]
    end = solve_ivp(slope, (0, 2 * np.pi / frequency), start, rtol=1e-11, atol=1e-13).y[2:, -1]
    exact = np.abs(np.linalg.eigvals(end.reshape(2, 2).T)).max()
    assert exact > 4e2
    assert largest.max() == pytest.approx(exact, rel=1e-3)


def test_a_curve_that_cannot_be_begun_is_one_row():
    """A softening spring that gives way under any forcing of that size."""
    flow = systems.reduced(**systems.DUFFING | {"cubic": [-1.0]}).return_map()
    (found,) = curve(flow, 50.0, 0.8, 1.2)
    assert found.orbit.outcome == Outcome.LOST
    assert np.isnan(found.swing.displacement).all() and np.isnan(found.multipliers).all()
