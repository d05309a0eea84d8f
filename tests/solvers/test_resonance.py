"""Phase resonance against closed forms: a linear oscillator, Duffing's backbone, work and damping;
isolas where the averaged equation has them.
"""

import numpy as np
import periodic_systems as systems
import pytest
from scipy.sparse import csr_matrix
from scipy.special import ellipk

from vibrom.artefacts.outcome import Outcome
from vibrom.solvers.periodic.carried import swept
from vibrom.solvers.periodic.continuation import Pace
from vibrom.solvers.periodic.equations import in_frequency
from vibrom.solvers.periodic.harmonic_balance import HarmonicBalance
from vibrom.solvers.periodic.resonance import backbone, damping_ratio
from vibrom.solvers.periodic.response import Span, response
from vibrom.solvers.periodic.stability import Kind
from vibrom.solvers.periodic.starts import from_backbone, from_sweeps

ONE = csr_matrix(np.eye(1))


def points(flow, found):
    """x, frequency, forcing and largest displacement of the first probe, motion by motion."""
    for orbit in found.orbits:
        x, frequency = found.problem.drive(orbit.point.x)
        swing = flow.swings(x[None], np.array([frequency]), np.array([orbit.p]))[0]
        yield x, frequency, orbit.p, swing.displacement[0].max()


@pytest.mark.parametrize("kind", [systems.full_order, systems.reduced])
def test_a_linear_oscillator_resonates_at_its_undamped_frequency(kind):
    """There it swings a/(c Omega) far."""
    damping = systems.DUFFING["damping"]
    flow = kind(**systems.DUFFING | {"cubic": [0.0]}).return_map()
    for x, frequency, forcing, largest in points(flow, backbone(flow, 0.1, 60, 0.25)):
        # 400 steps shift the frequency by (2 pi/400)^2/24 = 1e-5 and as much of the phase.
        assert frequency == pytest.approx(1.0, abs=5e-5)
        assert largest == pytest.approx(forcing / damping, rel=1e-4)
        assert damping_ratio(flow, ONE, x, frequency, forcing) == pytest.approx(
            damping / (2.0 * frequency), rel=1e-6
        )


def test_duffings_backbone_is_that_without_damping_and_forcing():
    """Its period is 4 K(m)/sqrt(1 + A^2), m = A^2/(2 + 2 A^2). The forcing is of order c and in
    quadrature with the motion, so that it shifts the frequency by order c^2.
    """
    errors = []
    for damping in (0.08, 0.04):
        flow = systems.reduced(**systems.DUFFING | {"damping": damping}).return_map()
        found = list(points(flow, backbone(flow, 2.0 * damping, 60, 0.25)))
        frequency, largest = np.array([(item[1], item[3]) for item in found]).T
        assert largest.max() > 1.3  # half as fast again as a small motion
        exact = 0.5 * np.pi * np.sqrt(1 + largest**2) / ellipk(largest**2 / (2 + 2 * largest**2))
        errors.append(np.abs(frequency / exact - 1.0).max())
    assert errors[1] < 2e-6 and errors[0] / errors[1] == pytest.approx(4.0, abs=0.4)


@pytest.mark.parametrize("kind", [systems.full_order, systems.reduced])
def test_damping_that_is_proportional_to_mass_does_not_depend_on_the_amplitude(kind):
    """The work of the load is c int v'Mv dt over a period of any motion."""
    flow = kind(**systems.TWO).return_map()
    mass = csr_matrix(systems.TWO["mass"])
    found = list(points(flow, backbone(flow, 0.1, 60, 0.25)))
    assert max(item[1] for item in found) > 1.1 * min(item[1] for item in found)
    for x, frequency, forcing, _ in found:
        zeta = damping_ratio(flow, mass, x, frequency, forcing)
        assert 2.0 * frequency * zeta == pytest.approx(systems.TWO["damping"], rel=1e-5)


def averaged(small):
    """Damping that falls and grows with the speed, of order e: by averaging, motions of amplitude A
    at resonance need the forcing  c1 A + 3/4 c3 A^3 + 5/8 c5 A^5,  which has a largest
    value, a smallest one, and a forcing between them.
    """
    factors = {"c1": 2.0 * small, "c3": -4.8 * small, "c5": 3.2 * small}
    need = np.poly1d([2.0 * small, 0.0, -3.6 * small, 0.0, 2.0 * small, 0.0])
    flow = systems.nonlinearly_damped(**factors, cubic=4.0 * small, reach=1.6).return_map()
    return flow, need, float(need(turns(need)).mean())


def turns(need):
    """Amplitudes at which the forcing has its largest and its smallest value."""
    return np.sort(need.deriv().roots.real)[-2:]


def test_a_backbone_comes_back_where_damping_falls_with_the_amplitude():
    errors = []
    for small in (0.01, 0.005):
        flow, need, forcing = averaged(small)
        found = backbone(flow, 2.0 * forcing, 100, 0.25)
        folds = [orbit.p for orbit in found.orbits if orbit.kind == Kind.FOLD]
        assert len(folds) == 2 and len(found.near(forcing)) == 3
        errors.append(np.abs(folds / need(turns(need)) - 1.0).max())
    # What averaging neglects is of order e.
    assert errors[1] < 0.01 and errors[0] / errors[1] == pytest.approx(2.0, abs=0.5)


def test_an_isola_is_found_from_the_backbone():
    """Between the two forcings motions of A in (0.72, 1.05) are apart from the small ones."""
    errors = []
    for small in (0.01, 0.005):
        flow, need, forcing = averaged(small)
        edges = np.sort((need - forcing).roots.real)[-2:]
        curve, pace = in_frequency(flow, forcing), Pace(1.5 * small, newton=True)
        span = Span(1.0 - 5 * small, 1.0 + 10 * small, 300, 1e-3 * small)
        alone = response(curve, span, pace)
        assert {item.branch for item in alone} == {0}
        found = response(curve, span, pace, from_backbone(flow, forcing, 100, 0.25))
        assert {item.branch for item in found} == {0, 1}
        isola = [item for item in found if item.branch == 1]
        assert isola[0].orbit.p == isola[-1].orbit.p  # it is closed
        assert isola[-1].orbit.outcome == Outcome.OK
        assert [item.orbit.kind for item in isola].count(Kind.FOLD) == 2
        size = [item.swing.displacement[0].max() for item in isola]
        errors.append(np.abs(np.array([min(size), max(size)]) - edges).max())
        assert max(item.swing.displacement[0].max() for item in alone) < 0.5
    assert errors[1] < 0.01 and errors[0] / errors[1] == pytest.approx(2.0, abs=0.5)
    # Harmonic balance finds it from the same guesses.
    balance = HarmonicBalance(flow, 3)
    near = from_backbone(flow, forcing, 100, 0.25)
    near = [(balance.of_point(x, omega, forcing), omega) for x, omega in near]
    balanced = response(in_frequency(balance, forcing), span, pace, near)
    sizes = [
        max(item.swing.displacement[0].max() for item in items if item.branch == 1)
        for items in (found, balanced)
    ]
    assert sizes[1] == pytest.approx(sizes[0], rel=1e-4)


def test_a_branch_is_found_from_a_sweep():
    """The upper motion, from a frequency at which a sweep upwards is still on it."""
    flow = systems.reduced(**systems.TWO).return_map()
    curve, span, pace = in_frequency(flow, 0.06), Span(0.6, 1.0, 300, 1e-3), Pace(0.04, newton=True)
    whole = response(curve, span, pace)
    near = from_sweeps(flow, 0.06, np.array([0.62, 0.70, 0.76]), 60)
    assert len(near) == 6 and near[0][1] == 0.62 and near[3][1] == 0.76
    # All of them lie on the one curve that there is.
    assert len(response(curve, span, pace, near)) == len(whole)
    (first,) = swept(flow, np.array([0.62]), 0.06, 60, 40)
    np.testing.assert_allclose(first, flow.after(np.zeros(4), 0.62, 0.06, 100), atol=1e-12)


def test_a_branch_without_an_end_at_rest_is_followed_to_both_sides():
    """Two motions from rest that are lost leave the guess alone: the whole curve hangs on it."""
    flow = systems.reduced(**systems.TWO).return_map()
    curve, pace = in_frequency(flow, 0.06), Pace(0.04, newton=True)
    span = Span(0.6, 1.0, 300, 1e-3)
    whole = response(curve, span, pace)
    middle = whole[len(whole) // 3].orbit

    class Broken(type(curve)):
        def ends(self, lowest, highest):
            return []

    alone = response(Broken(flow, None, 0.06), span, pace, [(middle.point.x, middle.p)])
    kinds = [item.orbit.kind for item in alone]
    assert kinds[0] == kinds[-1] == Kind.END
    assert sorted([alone[0].orbit.p, alone[-1].orbit.p]) == pytest.approx([0.6, 1.0])
    folds = [
        np.sort([item.orbit.p for item in items if item.orbit.kind == Kind.FOLD])
        for items in (whole, alone)
    ]
    np.testing.assert_allclose(*folds, rtol=1e-6)
    arcs = [item.orbit.point.arc for item in alone]
    assert arcs == sorted(arcs)
