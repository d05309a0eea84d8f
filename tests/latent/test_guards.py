"""Bounded extrapolation and dissipative fits: what they leave alone, and what they promise
everywhere.
"""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.sparse import csr_matrix

from vibrom.latent.autoencoder_rom import AutoencoderRom
from vibrom.latent.dissipative import (
    MARGIN,
    SLACK,
)
from vibrom.latent.extrapolation import continued, drawn_back
from vibrom.latent.polynomial import exponents, monomials, slopes
from vibrom.latent.polynomial_kernel import polynomial_kernel
from vibrom.latent.polynomial_rom import PolynomialRom
from vibrom.methods.modal_projection import ModalProjection
from vibrom.models.rollout import Integrator, rollout
from vibrom.models.rom import Guards, Rom, rom_from_dataset
from vibrom.models.training import MethodError, Structure, Training, Trajectory, Unsupported

RNG = np.random.default_rng(0)
REACH, SCALE = np.array([2.0, 0.5, 30.0, 9.0]), np.array([1.5, 0.4, 20.0, 10.0])


def test_slopes_are_those_of_differences():
    powers, y, along = exponents(3, 0, 5), RNG.uniform(-1, 1, (20, 3)), RNG.uniform(-1, 1, (20, 3))
    step = 1e-5
    differences = (monomials(y + step * along, powers) - monomials(y - step * along, powers)) / (
        2 * step
    )
    # Central differences of quintics: step^2 times a third derivative below 60, and roundings of
    # eps/step.
    np.testing.assert_allclose(
        slopes(y, powers, along), differences, atol=60 * step**2 + 10 * np.finfo(float).eps / step
    )


def test_inside_the_ellipse_nothing_changes_and_outside_it_goes_straight_on():
    powers, inside = (
        exponents(4, 1, 4),
        RNG.uniform(-0.7, 0.7, (50, 4)) * REACH,
    )  # each pair below 0.7 sqrt(2) < 1
    assert np.array_equal(drawn_back(inside, REACH), inside)
    assert np.array_equal(
        continued(inside, SCALE, REACH, powers), monomials(inside / SCALE, powers)
    )
    edge = RNG.standard_normal((50, 4))
    edge *= (
        np.tile(1 / np.hypot(edge[:, :2], edge[:, 2:]), 2) * REACH
    )  # both oscillators on their ellipses
    at = [continued(radius * edge, SCALE, REACH, powers) for radius in (1.0, 1.5, 2.0, 3.0)]
    size = np.abs(at[0]).max()
    np.testing.assert_allclose(at[2] - at[0], 2 * (at[1] - at[0]), atol=1e-13 * size)
    np.testing.assert_allclose(at[3] - at[0], 4 * (at[1] - at[0]), atol=1e-13 * size)
    # The slope along the radius from outside is that from inside: by Euler the degree times the
    # value.
    np.testing.assert_allclose(at[2] - at[0], at[0] * powers.sum(axis=1), atol=1e-13 * size)


def test_its_compiled_form():
    powers, coefficients = exponents(4, 1, 5), RNG.standard_normal((4, len(exponents(4, 1, 5))))
    z = RNG.uniform(-3, 3, (40, 4)) * REACH
    kernel = polynomial_kernel(SCALE, powers, coefficients, REACH)
    out, work, found = np.empty((4, 8)), np.full(8 * kernel.rows, np.nan), []
    for part in z.reshape(-1, 8, 4):
        kernel.function(np.ascontiguousarray(part.T), kernel.numbers, kernel.index, work, out)
        found.append(out.T.copy())
    right = continued(z, SCALE, REACH, powers) @ coefficients.T
    np.testing.assert_allclose(
        np.concatenate(found), right, rtol=0, atol=1e-12 * np.abs(right).max()
    )


def learnt(acceleration, *, start=0.8, periods=12, **guards) -> PolynomialRom:
    """Modal projection of one degree of freedom, omega = 1, released from `start`, with guards."""
    t = np.linspace(0, 2 * np.pi * periods, 200 * periods + 1)
    z, v = solve_ivp(
        lambda t, y: [y[1], acceleration(*y)],
        (0, t[-1]),
        [start, 0.0],
        t_eval=t,
        rtol=1e-11,
        atol=1e-13,
    ).y
    a = acceleration(z, v)
    structure = Structure(
        csr_matrix([[1.0]]), csr_matrix([[0.02]]), csr_matrix([[1.0]]), np.eye(1), np.ones(1)
    )
    return ModalProjection(**guards).learn(
        Training((Trajectory(t, z[:, None], v[:, None], a[:, None]),), structure=structure)
    )


def test_a_dissipative_fit_to_a_damped_oscillator_is_the_oscillator():
    rom = learnt(lambda z, v: -z - 0.02 * v - 0.4 * z**3 - 0.05 * v**3, dissipative=3)
    z = RNG.uniform(-0.5, 0.5, (20, 2))
    exact = np.stack(
        [z[:, 1], -z[:, 0] - 0.02 * z[:, 1] - 0.4 * z[:, 0] ** 3 - 0.05 * z[:, 1] ** 3], axis=1
    )
    np.testing.assert_allclose(rom.drift(z), exact, atol=1e-8)


# A softening spring with a well to leave; a spring that feeds energy in the middle; more of it at
# the rim; one that pushes outwards when fast.
FEEDING = {
    "softening": lambda z, v: -z - 0.02 * v + 1.2 * z**3,
    "van der Pol": lambda z, v: -z + 0.1 * (1 - 4 * z**2) * v,
    "fed at the rim": lambda z, v: -z - 0.02 * v + 0.1 * z**2 * v,
    "pushed": lambda z, v: -z - 0.02 * v + 1.5 * z * v**2,
}


@pytest.mark.parametrize(("name", "order"), [*product(FEEDING, (3, 5, 7)), ("van der Pol", 9)])
def test_a_dissipative_fit_is_damped_and_turns_everywhere(name, order):
    rom = learnt(FEEDING[name], dissipative=order)
    # In units of the range, to nine times its size; the points are none of those of the fit.
    radius, angle = np.append(np.arange(1, 102) / 101, [2.0, 9.0]), np.arange(1002) * np.pi / 501
    z = np.outer(radius, np.exp(1j * (angle + 1e-3))).ravel()
    z = np.stack([z.real, z.imag], axis=1)
    mirrored = z * [1, -1]
    forward, back = (
        rom.drift(part * rom.reach)[:, 1] * rom.reach[0] / rom.reach[1] ** 2
        for part in (z, mirrored)
    )
    even, odd, radius = (forward + back) / 2, (forward - back) / 2, np.hypot(*z.T)
    assert (odd * z[:, 1] <= 0.0).all()
    assert (z[:, 0] * even - z[:, 1] ** 2 <= (SLACK - MARGIN) * radius**2).all()


def tops(run) -> list[np.ndarray]:
    """The maxima of z of each run; between samples 400 to the period they are missed by at most
    (pi/400)^2/2 = 3e-5 of them.
    """
    found = []
    for z, velocity in run.reduced.transpose(0, 2, 1):
        (at,) = np.nonzero((velocity[:-1] > 0) & (velocity[1:] <= 0))
        found.append(np.maximum(z[at], z[at + 1]))
    return found


@pytest.mark.parametrize("name", ["softening", "fed at the rim"])
def test_released_beyond_its_range_it_comes_to_rest_where_the_plain_fit_does_not(name):
    start, times = (
        np.array([[1.3, 0.0], [-1.3, 0.0], [0.9, 0.9], [0.9, -0.9]]),
        np.linspace(0, 2 * np.pi * 40, 40 * 400),
    )
    rose = {}
    for guards in ({}, {"dissipative": 5}):
        rom = learnt(FEEDING[name], **guards)
        run = rollout(rom, start * rom.reach, np.tile(times, (4, 1)), Integrator(1e-8, 1e-10))
        rose[bool(guards)] = any(word == "diverged" for word in run.outcome) or any(
            (np.diff(top) > 1e-4 * rom.reach[0]).any() for top in tops(run)
        )
    assert rose == {False: True, True: False}


@pytest.mark.parametrize("guards", [Guards("linear"), Guards(dissipative=5)])
def test_an_autoencoder_that_is_the_identity_has_the_guards_of_a_polynomial(guards):
    """z = q = s c through a straight network, in a time that runs 2.5 times as fast."""
    t = np.linspace(0, 60, 2000)
    z, v = solve_ivp(
        lambda t, y: [y[1], FEEDING["softening"](*y)],
        (0, 60),
        [0.8, 0.0],
        t_eval=t,
        rtol=1e-11,
        atol=1e-13,
    ).y
    training = Training(
        (Trajectory(t, z[:, None], v[:, None], FEEDING["softening"](z, v)[:, None]),),
        structure=Structure(
            csr_matrix([[1.0]]), csr_matrix([[0.02]]), csr_matrix([[1.0]]), np.eye(1), np.ones(1)
        ),
    )
    plain = ModalProjection().fit(training)
    row = plain.dynamics[1] / np.prod(
        plain.scale**plain.dynamics_powers, axis=1
    )  # over monomials of z and z' themselves
    same = AutoencoderRom(
        plain.reach,
        np.array([1, 1]),
        np.zeros(2),
        np.array([[0.3]]),
        np.array([[1 / 0.3]]),
        None,
        0.3,
        2.5,
        (row * np.prod(np.array([1.0, 2.5]) ** plain.dynamics_powers, axis=1) / 2.5**2)[None],
        csr_matrix(np.ones((1, 1))),
        3,
        "silu",
        "decoder_mass",
    )
    points = RNG.uniform(-3, 3, (40, 2)) * plain.reach
    right = plain.guarded(guards, training).drift(points)
    guarded = same.guarded(guards, training)
    # The same least squares in other units: it loses the condition of the library, below 1e4.
    np.testing.assert_allclose(
        guarded.drift(points), right, rtol=0, atol=1e-10 * np.abs(right).max()
    )
    kernel, out, found = guarded.field(np.ones(1)).drift, np.empty((2, 8)), []
    for part in points.reshape(-1, 8, 2):
        kernel.function(
            np.ascontiguousarray(part.T),
            kernel.numbers,
            kernel.index,
            np.full(8 * kernel.rows, np.nan),
            out,
        )
        found.append(out.T.copy())
    np.testing.assert_allclose(
        np.concatenate(found), guarded.drift(points), rtol=0, atol=1e-12 * np.abs(right).max()
    )


@pytest.mark.parametrize("guards", [{"extrapolation": "linear"}, {"dissipative": 5}])
def test_a_guarded_polynomial_decoder_goes_straight_on_beyond_the_range_only(guards):
    guarded = learnt(FEEDING["softening"], **guards)
    guarded = replace(
        guarded,
        decoder=np.array([[1.0, 5.0], [1.0, 5.0]]) * guarded.scale[:, None],
        decoder_powers=np.array([[1, 0], [3, 0]]),
    )
    z = np.array([[radius, 0.0] for radius in (0.5, 1.0, 2.0, 3.0)]) * guarded.reach
    # y + 5 y^3 has the slope 16 at y = 1.
    np.testing.assert_allclose(
        guarded.decode(z)[:, 0] / guarded.scale[0], [1.125, 6.0, 22.0, 38.0], rtol=1e-14
    )
    assert np.array_equal(
        guarded.decode(z)[:2], replace(guarded, extrapolation="none").decode(z)[:2]
    )
    assert np.array_equal(guarded.displacement(z), guarded.decode(z)[:, :1])


def test_guards_are_stored(tmp_path):
    for guards in ({"extrapolation": "linear"}, {"dissipative": 5}):
        rom = learnt(FEEDING["softening"], **guards)
        back = rom_from_dataset(rom.to_dataset())
        z = RNG.uniform(-3, 3, (20, 2))
        assert back.extrapolation == "linear" and np.array_equal(back.drift(z), rom.drift(z))


def test_a_model_of_two_modes_is_refused_by_name():
    rom = replace(learnt(FEEDING["softening"]), encoder=np.eye(2))
    motion = Trajectory(np.arange(3.0), *np.ones((3, 3, 2)))
    with pytest.raises(Unsupported, match="set dissipative: 0"):
        rom.guarded(Guards(dissipative=3), Training((motion,)))


def test_wrong_guards_and_models_without_any():
    for wrong in ({"extrapolation": "flat"}, {"dissipative": -1}):
        with pytest.raises(MethodError, match=next(iter(wrong))):
            Guards(**wrong)

    class Own(Rom):
        encode = decode = drift = force_map = None

    own, training = Own(np.ones(2)), Training((Trajectory(np.zeros(1), *np.ones((3, 1, 1))),))
    assert own.guarded(Guards(), training) is own
    with pytest.raises(Unsupported, match="Own has no guards"):
        own.guarded(Guards("linear"), training)
