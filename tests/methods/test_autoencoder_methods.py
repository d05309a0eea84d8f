"""Methods with an autoencoder, on motions whose reduced dynamics are known (`bent_oscillator`)."""

from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import pytest
import yaml
from bent_oscillator import (
    DAMPING,
    FREQUENCIES,
    MASS,
    MODES,
    QUICK,
    SIZE,
    N,
    oscillate,
    structure,
    training,
)
from scipy.integrate import solve_ivp

from vibrom.methods import method_from_settings
from vibrom.methods.decoupled_autoencoder import DecoupledAutoencoder
from vibrom.methods.sindy_autoencoder import SindyAutoencoder
from vibrom.methods.split import Split
from vibrom.methods.split_plus import SplitPlus
from vibrom.models.rom import rom_from_dataset
from vibrom.models.training import MethodError, TrainingDiverged

pytestmark = pytest.mark.usefixtures("one_thread")

METHODS = {"decoupled": DecoupledAutoencoder, "sindy": SindyAutoencoder, "split": Split}


@pytest.fixture(
    scope="module",
    params=[
        (name, latent, linear) for name in METHODS for latent, linear in ((1, "none"), (2, "modes"))
    ],
    ids=lambda item: "-".join(map(str, item)),
)
def fitted(request):
    name, latent, linear = request.param
    data = training(latent)
    return METHODS[name](**QUICK | {"latent": latent, "linear": linear, "rank": 5}).fit(data), data


def test_velocity_and_acceleration_are_the_chain_rule(fitted):
    rom, data = fitted
    item, step = data.trajectories[0], 1e-5
    x, moved = item.state[5:50], (item.state + step * item.rate)[5:50]
    back = (item.state - step * item.rate)[5:50]
    z = rom.encode(x)
    d = rom.latent
    slope = (rom.encode(moved) - rom.encode(back)) / (2 * step)
    scaled = rom.encoded(data)[:, 5:50]
    motion = [scaled[1] * rom.frequency, scaled[2] * rom.frequency**2]
    assert np.allclose(slope, np.hstack(motion), rtol=1e-4, atol=1e-4 * np.abs(slope).max(axis=0))
    # q' is the derivative of q along z'.
    along = np.hstack([z[:, d:], np.zeros_like(z[:, d:])])
    decoded = (rom.decode(z + step * along) - rom.decode(z - step * along))[:, :N] / (2 * step)
    assert np.allclose(decoded, rom.decode(z)[:, N:], atol=1e-5 * np.abs(decoded).max())


def test_shapes_and_batches(fitted):
    rom, data = fitted
    x = data.trajectories[0].state[:12].reshape(3, 4, -1)
    z = rom.encode(x)
    p = structure().mass @ MODES[0]
    for function in (rom.encode, rom.decode, rom.drift, lambda z: rom.force_map(z, p)):
        values = x if function == rom.encode else z
        assert np.allclose(function(values)[1, 2], function(values[1, 2]), rtol=1e-10, atol=1e-12)
    assert z.shape == (3, 4, 2 * rom.latent) and rom.decode(z).shape == x.shape


@pytest.mark.parametrize("settings", [{}, {"optimiser": "adam", "batch": 32}, {"latent": 2}])
def test_split_of_order_one_has_the_known_linear_dynamics(settings):
    d = settings.get("latent", 1)
    rom = Split(**QUICK | settings, order=1).fit(training(d))
    z = np.random.default_rng(0).standard_normal((5, 2 * d)) * np.repeat([1.0, FREQUENCIES[0]], d)
    right = -(FREQUENCIES[:d] ** 2) * z[:, :d] - DAMPING * z[:, d:]
    np.testing.assert_allclose(
        rom.drift(z), np.hstack([z[:, d:], right]), rtol=1e-12, atol=1e-12 * np.abs(right).max()
    )


@pytest.mark.parametrize("rule", ["decoder", "decoder_mass", "encoder"])
def test_force_map_is_linear_in_the_load(fitted, rule):
    rom, data = fitted
    rom = replace(rom, force_rule=rule)
    z = rom.encode(data.trajectories[0].state[:20])
    one, two = np.random.default_rng(0).standard_normal((2, N))
    whole = rom.force_map(z, 2.0 * one - 3.0 * two)
    assert np.allclose(
        whole,
        2.0 * rom.force_map(z, one) - 3.0 * rom.force_map(z, two),
        atol=1e-9 * np.abs(whole).max(),
    )
    assert np.all(whole[:, : rom.latent] == 0.0)


@pytest.mark.parametrize("rule", ["decoder", "decoder_mass"])
def test_a_load_along_the_decoders_tangent_moves_that_coordinate_only(fitted, rule):
    rom, data = fitted
    rom = replace(rom, force_rule=rule)
    z = rom.encode(data.trajectories[0].state[7])
    for axis in range(rom.latent):
        along = z.copy()
        along[rom.latent :] = np.eye(rom.latent)[axis]
        p = structure().mass @ rom.decode(along)[N:]
        assert np.allclose(rom.force_map(z, p)[rom.latent :], np.eye(rom.latent)[axis], atol=1e-8)


def test_saved_equals_loaded(fitted, tmp_path):
    rom, data = fitted
    path = tmp_path / "rom.nc"
    rom.to_dataset().to_netcdf(path)
    import xarray as xr

    again = rom_from_dataset(xr.load_dataset(path))
    z, p = rom.encode(data.trajectories[0].state[:9]), MASS
    assert np.array_equal(again.encode(data.trajectories[0].state[:9]), z)
    for function in ("drift", "decode"):
        assert np.array_equal(getattr(again, function)(z), getattr(rom, function)(z))
    assert np.array_equal(again.force_map(z, p), rom.force_map(z, p))


def test_rest_stays_at_rest(fitted):
    rom, _ = fitted
    assert not rom.encode(np.zeros(2 * N)).any() and not rom.decode(np.zeros(2 * rom.latent)).any()
    assert not rom.drift(np.zeros(2 * rom.latent)).any()


def simulate(rom, item):
    return solve_ivp(
        lambda t, z: rom.drift(z),
        (0, item.time[-1]),
        rom.encode(item.state[0]),
        t_eval=item.time,
        rtol=1e-9,
        atol=1e-12,
    ).y.T


def nmte(item, q):
    return (
        100
        * np.linalg.norm(item.displacement - q, axis=1).mean()
        / np.linalg.norm(item.displacement, axis=1).max()
    )


def test_split_and_split_plus_find_the_oscillator():
    data = training()
    rom = Split(hidden=(12,), rank=0, linear="modes", every=1, epochs=400).fit(data)
    pole = np.linalg.eigvals(
        np.stack([rom.drift(1e-7 * axis) / 1e-7 for axis in np.eye(2)], axis=1)
    )
    assert np.allclose(
        sorted(pole.imag),
        np.array([-1, 1]) * np.sqrt(FREQUENCIES[0] ** 2 - DAMPING**2 / 4),
        rtol=1e-6,
    )
    item = oscillate(np.array([0.7 * SIZE]))
    # A small network after a short training: errors of half a per cent of the largest displacement,
    # against tens at the start.
    assert nmte(item, rom.decode(rom.encode(item.state))[:, :N]) < 0.5
    assert nmte(item, rom.decode(simulate(rom, item))[:, :N]) < 2.0
    plus = SplitPlus().fit(replace(data, start=rom))
    assert nmte(item, plus.decode(simulate(plus, item))[:, :N]) < 2.0
    assert np.array_equal(plus.encode(item.state), rom.encode(item.state))


def test_free_methods_need_no_structure():
    """A load is an acceleration then: one along the shape accelerates the coordinate by one."""
    data = training(structure=None)
    for method in (DecoupledAutoencoder, SindyAutoencoder):
        rom = method(**QUICK).fit(data)
        assert 15.0 < rom.frequency < 40.0
        ends = rom.displacement(np.array([[1e-6, 0.0], [-1e-6, 0.0]]))
        pushed = rom.force_map(np.zeros(2), (ends[0] - ends[1]) / 2e-6)
        np.testing.assert_allclose(pushed, [0.0, 1.0], atol=1e-5)
    with pytest.raises(MethodError, match="linear: modes needs mass"):
        Split(**QUICK).fit(data)
    with pytest.raises(MethodError, match="needs mass"):
        SindyAutoencoder(**QUICK | {"linear": "modes"}).fit(data)


LITERAL = yaml.safe_load((Path(__file__).parents[2] / "config/thesis_literal.yaml").read_text())[
    "method_settings"
]


@pytest.mark.parametrize(
    "name", sorted(set(LITERAL) - {"split_plus"})
)  # which trains nothing of its own
def test_the_literal_recipe_runs(name):
    """The overlay that a user runs for 15 000 epochs, for three of them."""
    rom = method_from_settings(name, {**LITERAL[name], "epochs": 3}).fit(training())
    assert rom.frequency == rom.scale == 1.0 and rom.basis is None
    assert np.isfinite(rom.coefficients).all()


def test_a_training_that_diverges_says_so():
    with pytest.raises(TrainingDiverged, match="of 200"):
        Split(**QUICK | {"epochs": 200, "learning_rate": 1e9}).fit(training())


def test_split_plus_names_what_it_lacks():
    with pytest.raises(MethodError, match="starts_from"):
        SplitPlus().fit(training())


def test_a_fitted_model_imports_no_torch():
    import subprocess
    import sys

    script = (
        "import sys, vibrom.latent.autoencoder_rom, vibrom.methods.split; "
        "assert 'torch' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", script], check=True)


def test_settings_are_stored_as_plain_values():
    assert all(
        isinstance(value, (int, float, str, bool, tuple)) for value in asdict(Split()).values()
    )
