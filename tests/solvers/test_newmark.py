"""Newmark: the damped mode in closed form, order two, energy, and where a motion starts."""

import numpy as np
import pytest
from numba import njit
from scenes import CANTILEVER, LINEAR, UNDAMPED, body

from vibrom import effects
from vibrom.bodies import space
from vibrom.kernels.lanes import get, put
from vibrom.solvers.full.modes import eigenmodes
from vibrom.solvers.full.newmark import Newmark, Record
from vibrom.solvers.full.scheme import extrapolated, predicted, weights
from vibrom.solvers.full.schemes import newmark


@pytest.fixture(scope="module")
def undamped():
    made = space.build(body(cells=[4, 1], height=0.2))
    return made, effects.assemble(made, UNDAMPED)


def test_linear_decay_is_that_of_the_damped_mode():
    """q = phi e^{-zeta omega t} (cos omega_d t + zeta/sqrt(1-zeta^2) sin omega_d t), up to the
    method's second order.
    """
    made = space.build(CANTILEVER)
    term = effects.assemble(made, {**LINEAR, "rayleigh_damping": {"damping_ratio": 0.01}})
    (omega,), (phi,) = (part[:1] for part in eigenmodes(term, 1))
    damped, steps = omega * np.sqrt(1 - 1e-4), 2000
    step = 2 * np.pi / damped / 400
    motion = Newmark().run(term, 0.01 * phi[:, None], np.array([step]), steps)
    t = motion.kept * step
    exact = (
        0.01
        * np.exp(-0.01 * omega * t)
        * (np.cos(damped * t) + 0.01 / np.sqrt(1 - 1e-4) * np.sin(damped * t))
    )
    modal = motion.displacement[0] @ (term.mass @ phi)
    # Period error (omega h)^2/12 = 2e-5 a radian, over 5 periods 31 rad: 6.5e-4 of the amplitude.
    assert np.abs(modal - exact).max() <= 0.01 * 1.05 * (omega * step) ** 2 / 12 * damped * t[-1]


SCHEME = newmark.scheme(0.01)


@njit
def of_lanes(q, v, a, past, h, ends):
    """The formulas on registers of two states, as a compiled step evaluates them."""
    plain = predicted(SCHEME, get(h, 0, 2), get(q, 0, 2), get(v, 0, 2), get(a, 0, 2))
    guess = extrapolated(
        get(a, 0, 2), get(past, 0, 2), get(past, 1, 2), get(past, 2, 2), get(past, 3, 2)
    )
    for place, value in enumerate((*plain, guess)):
        put(ends, place, value)


def test_formulas_are_the_same_for_arrays_and_for_lanes():
    """A motion of constant acceleration is exact; the guess is exact for a cubic and an
    alternation of sign.
    """
    h = np.array([[0.1, 0.2]])
    t = np.arange(-4.0, 2.0)[:, None] * h
    a = 1.0 + 2.0 * t - 3.0 * t**2 + 5.0 * t**3 + 0.7 * (-1.0) ** np.arange(6)[:, None]
    q, v, past = np.full((1, 2), 0.3), np.full((1, 2), -0.4), a[3::-1].copy()
    by_q, by_v = weights(SCHEME, h)
    plain_q, plain_v = predicted(SCHEME, h, q, v, a[4:5])
    np.testing.assert_allclose(plain_q + by_q * a[4:5], q + h * v + h**2 / 2 * a[4:5], rtol=1e-14)
    np.testing.assert_allclose(plain_v + by_v * a[4:5], v + h * a[4:5], rtol=1e-14)
    guess = extrapolated(a[4:5], *past[:, None])
    np.testing.assert_allclose(guess, a[5:6], rtol=1e-12)
    ends = np.zeros((3, 2))
    of_lanes(q, v, a[4:5].copy(), past, h, ends)
    np.testing.assert_allclose(ends, np.concatenate([plain_q, plain_v, guess]), rtol=1e-14)


def test_order_two(undamped):
    """The steps resolve even the fastest mode, which the release excites: only then is the error
    that of the leading order.
    """
    made, term = undamped
    (omega,), (phi,) = (part[:1] for part in eigenmodes(term, 1))
    start = (0.2 / np.abs(phi).max() * phi)[:, None]
    period, ends = 2 * np.pi / omega, []
    counts = [4000, 8000, 16000, 32000]
    for count in counts:
        motion = Newmark(tolerance=1e-10).run(
            term, start, np.array([0.25 * period / count]), count, record=Record(every=count)
        )
        assert motion.outcomes == ["ok"]
        ends.append(phi @ (term.mass @ motion.displacement[0, -1]))
    # Three halvings give two ratios of successive differences, each 2^order.
    orders = np.log2(np.abs(np.diff(ends))[:-1] / np.abs(np.diff(ends))[1:])
    np.testing.assert_allclose(orders, 2.0, atol=0.1)


def test_energy_of_an_undamped_motion_stays(undamped):
    """Trapezoidal rule: energy is not conserved exactly by a nonlinear body, but its error is of
    second order and does not drift away.
    """
    made, term = undamped
    (omega,), (phi,) = (part[:1] for part in eigenmodes(term, 1))
    start = (0.05 / np.abs(phi).max() * phi)[:, None]
    errors = []
    for count in (4000, 8000):
        motion = Newmark(tolerance=1e-10).run(
            term,
            start,
            np.array([2 * np.pi / omega / count]),
            3 * count,
            record=Record(every=count // 50),
        )
        energy = np.array(
            [
                0.5 * v @ (term.mass @ v) + strain_energy(made, term, q)
                for q, v in zip(motion.displacement[0], motion.velocity[0])
            ]
        )
        errors.append(np.abs(energy / energy[0] - 1).max())
    assert errors[1] < 1e-4 and errors[1] == pytest.approx(errors[0] / 4, rel=0.2)


def test_energy_of_the_folding_beam(cantilever):
    """The thesis's beam, released undamped from the shape in which it folds: what gamma = 1/2 and
    the thesis's alpha do to its energy.
    """
    made, term = cantilever
    free, step = effects.assemble(made, UNDAMPED), 2 * np.pi / 398.0325
    signal = 3000 * np.sin(2 * np.pi * np.arange(13377) / 1000)[:, None]
    shape = Newmark(alpha=0.005).run(
        term,
        np.zeros((made.size, 1)),
        np.array([step / 1000]),
        13376,
        signal=signal,
        record=Record(start=13376),
    )
    drift = {}
    for alpha, count in ((0.0, 500), (0.0, 1000), (0.005, 1000)):
        motion = Newmark(alpha=alpha, tolerance=1e-7).run(
            free,
            shape.displacement[0].T,
            np.array([step / count]),
            30 * count,
            record=Record(every=count // 10),
        )
        energy = np.array(
            [
                0.5 * v @ (free.mass @ v) + strain_energy(made, free, q)
                for q, v in zip(motion.displacement[0], motion.velocity[0])
            ]
        )
        drift[alpha, count] = energy[-1] / energy[0] - 1, np.abs(energy / energy[0] - 1).max()
    # Second order without numerical damping: four times less for half the step; with it, energy can
    # only fall.
    assert (
        drift[0.0, 1000][1] == pytest.approx(drift[0.0, 500][1] / 4, rel=0.1)
        and drift[0.0, 1000][1] < 1e-4
    )
    assert -0.05 < drift[0.005, 1000][0] < 0


def strain_energy(made, term, u):
    """W = int_0^1 u . f(s u) ds exactly: f is a cubic in s, so two Gauss points do."""
    force, points = term.forces[0], 0.5 + np.array([-0.5, 0.5]) / np.sqrt(3)
    total = 0.0
    for s in points:
        f = np.zeros((made.size, 1))
        force.kernels(1)[0](s * u[:, None], np.zeros((made.size, 1)), force.dofs, force.table, f)
        total += 0.5 * u @ (term.stiffness @ (s * u) + f[:, 0])
    return total


def test_equilibrium_gives_the_initial_acceleration(cantilever):
    made, term = cantilever
    start = np.random.default_rng(0).standard_normal((made.size, 1)) * 1e-3
    motion = Newmark().run(term, start, np.array([1e-5]), 1)
    f = np.zeros((made.size, 1))
    force = term.forces[0]
    force.kernels(1)[0](start, np.zeros_like(start), force.dofs, force.table, f)
    residual = term.mass @ motion.acceleration[0, 0] + term.stiffness @ start[:, 0] + f[:, 0]
    assert np.abs(residual).max() <= 1e-9 * np.abs(f).max()


def test_a_start_that_is_stretched_far(cantilever):
    """Bent along a straight mode the axis is too long: at the first step the usual guess goes far
    astray, and the tangent there is indefinite.
    """
    made, _ = cantilever
    term = effects.assemble(made, {**UNDAMPED, "rayleigh_damping": {"damping_ratio": 0.01}})
    (omega,), (phi,) = (part[:1] for part in eigenmodes(term, 1))
    start, step = (0.01 / np.abs(phi).max() * phi)[:, None], np.array([2 * np.pi / omega / 1000])
    coarse = Newmark(alpha=0.005).run(term, start, step, 200)
    fine = Newmark(alpha=0.005).run(term, start, step / 8, 1600, record=Record(every=8))
    assert coarse.outcomes == fine.outcomes == ["ok"]
    # The bending is resolved to (omega h)^2/12 a radian, 4e-6 of it over this fifth of a period;
    # the axial swing that comes with it is not.
    tip = np.abs(phi).argmax()
    assert (
        np.abs(coarse.displacement[0, :, tip] - fine.displacement[0, :, tip]).max()
        <= 1e-3 * np.abs(start).max()
    )
