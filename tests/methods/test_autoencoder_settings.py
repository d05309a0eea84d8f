"""What autoencoders are fitted by: norms, least squares, and settings that they refuse."""

import numpy as np
import pytest
import torch
from bent_oscillator import FREQUENCIES, QUICK, structure, training

from vibrom.latent.coefficients import fit_first_order, least_loss
from vibrom.latent.coordinates import Coordinates, static_norm
from vibrom.latent.learner import Learner
from vibrom.latent.polynomial import exponents, monomials
from vibrom.methods.decoupled_autoencoder import DecoupledAutoencoder
from vibrom.methods.split import Split
from vibrom.models.training import MethodError

pytestmark = pytest.mark.usefixtures("one_thread")


def test_the_norm_of_accelerations():
    data = training(2)
    norms = {}
    for norm in ("static", "plain"):
        method = Split(**QUICK | {"acceleration_norm": norm})
        problem = method.problem(data)
        norms[norm] = problem.dynamics
        balance = np.sum(problem.train[0] ** 2) / np.sum(problem.train[2] ** 2)
        assert np.isclose(problem.dynamics.reduced, method.acceleration_reduced * balance)
    assert norms["plain"].norm is None and np.isclose(
        norms["plain"].full, method.acceleration_full * balance
    )
    assert norms["static"].full == method.acceleration_full
    with pytest.raises(MethodError, match="acceleration_norm is 'dynamic'"):
        Split(acceleration_norm="dynamic")


@pytest.mark.parametrize("latent, linear, norm", [(1, "pod", "plain"), (2, "modes", "static")])
def test_refitted_coefficients_are_where_the_loss_has_no_slope(latent, linear, norm):
    data = training(latent)
    method = Split(
        **QUICK, latent=latent, linear=linear, acceleration_norm=norm, precision="float64"
    )
    problem = method.problem(data)
    learner = Learner(
        problem.autoencoder,
        problem.dynamics,
        torch.float64,
        problem.device,
        torch.Generator().manual_seed(0),
    )
    c, rom = torch.tensor(problem.train), method.model(data, problem, *learner.learnt())
    slopes = []
    found = least_loss(problem.dynamics, rom.encoder, rom.decoder, problem.train)
    for xi in (np.zeros_like(found), found):
        learner.parts[-1].copy_(torch.tensor(xi / problem.dynamics.gain))
        learner.losses(c)
        slopes.append(float(learner.slopes[-1].abs().max()))
    assert slopes[1] < 1e-9 * slopes[0]


def test_least_squares_weigh_amplitudes():
    """z'' = -z - 0.02 z' + 0.3 z^3 is found from any weights; from errors in proportion to the
    amplitude, best where those are levelled.
    """
    rng, exact = np.random.default_rng(1), np.zeros(9)
    exact[[0, 1, 5]] = (
        -1.0,
        -0.02,
        0.3,
    )  # z, z' and z^3 among z, z', z^2, z z', z'^2, z^3, z^2 z', ...
    amplitude = np.exp(-np.linspace(0, 5, 3000))
    y = amplitude[:, None] * rng.standard_normal((3000, 2))
    library = monomials(y, exponents(2, 1, 3))
    clean, size, spread = library @ exact, np.linalg.norm(y, axis=1), {}
    for power in (0.0, -0.5, -1.0):

        def fit(second, power=power):
            motion = np.stack([y[:, :1], y[:, 1:], second[:, None]])
            return fit_first_order(motion, 3, None, power)[1]

        assert np.allclose(fit(clean), exact, atol=1e-10)
        off = []
        for noise in rng.standard_normal((20, 3000)) * 0.05 * size:
            weight, second = size ** (2 * power), clean + noise
            normal = np.linalg.solve(
                library.T @ (weight[:, None] * library), library.T @ (weight * second)
            )
            assert np.allclose(fit(second), normal, atol=1e-9)
            off.append(fit(second) - exact)
        spread[power] = np.std(off, axis=0)
    assert (spread[-1.0][:2] < 0.6 * spread[0.0][:2]).all()


def test_a_static_norm_weighs_each_mode_by_the_square_of_its_period():
    known = structure()
    for basis, scale in ((None, 1.0), (np.linalg.qr(known.modes[:3].T)[0], 0.3)):
        chosen = Coordinates(basis, scale, FREQUENCIES[0])
        for mode, frequency in zip(known.modes[:3], known.frequencies):
            c = chosen.reduce(mode)
            assert np.allclose(
                static_norm(known, chosen) @ c,
                (FREQUENCIES[0] / frequency) ** 2 * c,
                atol=1e-12 * np.abs(c).max(),
            )


@pytest.mark.parametrize(
    "setting, value",
    [
        ("activation", "relu"),
        ("decoder_beyond", "flat"),
        ("force_rule", "guess"),
        ("latent", 0),
        ("linear", "mode"),
        ("every", 0),
        ("optimiser", "sgd"),
    ],
)
def test_a_bad_value_is_named(setting, value):
    with pytest.raises(MethodError, match=setting):
        Split(**{setting: value})


@pytest.mark.parametrize("linear", ["none", "pod", "modes"])
def test_fewer_directions_than_coordinates_are_refused(linear):
    with pytest.raises(
        MethodError, match="rank is 1, fewer directions than latent = 2; give 2 or more, or 0"
    ):
        DecoupledAutoencoder(**QUICK | {"rank": 1, "latent": 2, "linear": linear})


@pytest.mark.parametrize("rank, linear", [(0, "modes"), (14, "modes"), (0, "none")])
def test_more_coordinates_than_the_data_or_the_modes_span_are_refused(rank, linear):
    with pytest.raises(MethodError, match="latent = 7"):
        Split(**QUICK | {"rank": rank, "latent": 7, "linear": linear}).fit(training())


def test_fewer_samples_than_terms_are_refused():
    """Two coordinates and order 3: 9 terms."""
    with pytest.raises(MethodError, match="every = 100 leaves 3 samples to train on, fewer than"):
        Split(**QUICK | {"every": 100}).fit(training())
