"""Periodic motions followed in their action, against the quadratures of Duffing's oscillator.

u'' + u + u^3 = 0,    E = u'^2/2 + u^2/2 + u^4/4,    J = (1/2 pi) closed integral of u' du
"""

import numpy as np
import periodic_systems as systems
import pytest
from few_dofs import SPRING, duffing
from scipy.integrate import quad
from scipy.sparse import csr_matrix

from vibrom.solvers.manifold import shooting
from vibrom.solvers.manifold.orbits import Family, Orbits, fitted, follow, turning
from vibrom.solvers.manifold.parametrisation import parametrise
from vibrom.solvers.manifold.shooting import shoot
from vibrom.term import Force, Term

HARMONICS, DAMPING = 12, 0.02
ANGLE = 2 * np.pi * np.arange(2 * HARMONICS + 1) / (2 * HARMONICS + 1)


def _force(q, v, dofs, table, f):
    f[0] += q[0] ** 3


def _tangent(q, v, dofs, table, slots, scale_q, scale_v, values):
    values[slots[0, 0]] += scale_q * 3.0 * q[0] ** 2


def moving():
    """Duffing's oscillator with kernels."""
    one = csr_matrix(np.eye(1))
    force = Force(
        lambda width: (_force, _tangent),
        np.zeros((1, 1), np.int64),
        np.zeros((1, 1)),
        quartic=lambda: (SPRING,),
    )
    return Term(one, DAMPING * one, one, (force,))


def oscillator():
    """The same in compiled code."""
    one = np.eye(1)
    return systems.term(one, one, [1.0], [1.0], DAMPING)


def by_quadrature(amplitude):
    """Action and frequency; u = A sin s takes the roots out of the integrals."""

    def speed(s):  # u' over A cos s
        return np.sqrt(1.0 + 0.5 * amplitude**2 * (1.0 + np.sin(s) ** 2))

    quarter = quad(lambda s: 1.0 / speed(s), 0.0, np.pi / 2)[0]
    area = quad(lambda s: (amplitude * np.cos(s)) ** 2 * speed(s), 0.0, np.pi / 2)[0]
    return 4.0 * area / (2 * np.pi), 2 * np.pi / (4.0 * quarter)


@pytest.fixture(scope="module")
def family():
    return Family(moving(), np.zeros(1), np.eye(1), HARMONICS)


@pytest.fixture(scope="module")
def orbits(family):
    """From five small motions, with their cubic terms, to large ones."""
    x = (0.02 * np.arange(1, 6)) ** 2  # action over 2 w_0, w_0 = 1
    amplitude = 2.0 * np.sqrt(x)
    rate = -DAMPING / 2 + 1j * (1.0 + 3.0 / 8.0 * amplitude**2)
    values = amplitude[:, None] * np.cos(ANGLE)
    return follow(family, Orbits(x, rate, values[..., None]), 0.02, 1.0)


def test_amplitude_and_frequency_are_those_of_the_quadratures(orbits):
    assert orbits.action[-1] == pytest.approx(0.98**2)  # the last but one step to 1
    for at in (0, 20, 43):
        amplitude = orbits.values[at, 0, 0]
        action, frequency = by_quadrature(amplitude)
        # The five small motions leave out terms of degree five: 1e-5 of the first one's action.
        np.testing.assert_allclose(2.0 * orbits.action[at], action, rtol=2e-2)
        np.testing.assert_allclose(np.abs(orbits.rate[at]), frequency, rtol=1e-8)
    # Relative to one another, the actions are exact.
    ratio = [by_quadrature(orbits.values[at, 0, 0])[0] / orbits.action[at] for at in (5, 40)]
    np.testing.assert_allclose(ratio[1], ratio[0], rtol=1e-8)


def test_damping_by_the_mass_decays_alike_everywhere(orbits):
    np.testing.assert_allclose(orbits.rate.real, -DAMPING / 2, rtol=1e-10)


def test_shooting_finds_the_motions_of_the_quadratures():
    """Its steps lose (w h)^2/24 of each harmonic's frequency: 2e-5 of the first and 2e-4 of the
    third, which is a twentieth of the motion.
    """
    small = 0.1 * np.linspace(0.5, 1.0, 5)
    exact = [by_quadrature(2.0 * each) for each in small]
    action, frequency = (np.array(part) for part in zip(*exact))
    rate = -DAMPING / 2 + 1j * frequency
    values = 2.0 * small[:, None] * np.cos(ANGLE)
    begun = Orbits(0.5 * action, rate, values[..., None])
    found = shoot(oscillator(), np.zeros(1), np.ones(1), begun, 1.0)
    assert np.sqrt(found.action[-1]) > 1.0 and len(found.action) > 8
    amplitude = found.values[:, 0, 0]
    np.testing.assert_allclose(found.values.max(axis=1)[:, 0], amplitude, rtol=1e-6)
    action, frequency = (np.array(part) for part in zip(*map(by_quadrature, amplitude)))
    np.testing.assert_allclose(np.abs(found.rate), frequency, rtol=1e-4)
    # The cosines that it begins from leave out terms of degree five, 3 A^2/32 of their action.
    ratio = 2.0 * found.action / action
    np.testing.assert_allclose(ratio, 1.0, rtol=3.0 / 32.0 * 0.2**2)
    np.testing.assert_allclose(ratio, ratio[0], rtol=1e-4)
    np.testing.assert_allclose(found.rate.real, -DAMPING / 2, rtol=1e-6)


def test_shooting_that_cannot_begin_finds_nothing():
    """Motions that are no motions of this body."""
    values = np.full((5, len(ANGLE), 1), 1e3) * np.cos(ANGLE)[:, None]
    begun = Orbits(np.linspace(0.1, 0.2, 5), 1j * np.ones(5), values)
    assert len(shoot(oscillator(), np.zeros(1), np.ones(1), begun, 1.0).action) == 0


@pytest.mark.parametrize(
    "end",
    [np.linspace(1.09, 1.0, 9), np.linspace(1.1, 1.1 + 2e-5, 9)],
    ids=["leads back", "creeps"],
)
def test_a_branch_is_followed_while_its_action_grows(monkeypatch, end):
    """A resonance within the body may turn it; a dip is passed."""
    roots, asked = [0.5, 0.9, 0.8995, 1.0, 1.1, *end, 2.0], []

    def measured(problem, term, point, begun):
        asked.append(point)
        return roots[point], 1j, begun.values[-1]

    monkeypatch.setattr(shooting, "_begin", lambda flow, begun: (None, 0, None))
    monkeypatch.setattr(shooting, "_measured", measured)
    monkeypatch.setattr(shooting.continuation, "walk", lambda *_: iter(range(1, len(roots))))
    values = np.cos(ANGLE)[None, :, None]
    begun = Orbits(np.array([0.36]), np.array([1j]), values)
    found = np.sqrt(shoot(oscillator(), np.zeros(1), np.ones(1), begun, 3.0).action)
    assert (np.diff(found) > 0.0).all()
    np.testing.assert_allclose(found[:3], [0.9, 1.0, 1.1])
    np.testing.assert_allclose(found[-1], 1.1, rtol=1e-4)
    assert asked == list(range(5 + shooting.WAIT))


def test_differences_of_a_trigonometric_polynomial_are_exact():
    y = np.sin(3 * ANGLE) - 0.5 * np.cos(HARMONICS * ANGLE)
    slope = 3 * np.cos(3 * ANGLE) + 0.5 * HARMONICS * np.sin(HARMONICS * ANGLE)
    np.testing.assert_allclose(turning(len(ANGLE)) @ y, slope, atol=1e-11)


def test_polynomials_through_the_motions_reproduce_those_between(orbits):
    """Every other motion is left out. For imaginary u the well u^2/2 - u^4/4 ends at the action
    0.30, so that the nearest singularity is at X = -0.15: polynomials of degree 8 on 0 < X < 0.96
    leave out some r^-9 = 1e-3 of what curves, r = 2.15 of Bernstein's ellipse; it is mild, and
    less is left.
    """
    manifold = parametrise(duffing(DAMPING), (1,), 5)
    every = Orbits(*(part[::2] for part in vars(orbits).values()))
    found = fitted(manifold, np.eye(1), every, 17)
    for at in (1, 21, 41):
        x = orbits.action[at]
        z = np.sqrt(x) * np.exp(1j * ANGLE)
        library = found.monomials.values(np.stack([z, z.conj()], axis=-1))
        shape = library @ found.displacement
        np.testing.assert_allclose(shape, orbits.values[at], atol=1e-4)
        rate = (library @ found.dynamics[0])[0] / z[0]
        np.testing.assert_allclose(rate, orbits.rate[at], rtol=1e-4)
        speed = (library @ found.velocity).real[:, 0]
        turned = orbits.rate[at].imag * (turning(len(ANGLE)) @ orbits.values[at, :, 0])
        # In the family it also decays, by a hundredth.
        assert np.abs(speed - turned).max() < 2 * DAMPING * np.abs(turned).max()
