"""Rollouts: compiled models against outside ones, which have four functions and no more."""

import subprocess
import sys
from dataclasses import dataclass

import numpy as np
import pytest
from oscillators import OMEGA, linear_rom

from vibrom.models.rollout import Drive, Integrator, decode_displacement, rollout
from vibrom.models.rom import Rom, rom_from_dataset
from vibrom.models.training import MethodError


@dataclass(frozen=True)
class Outside(Rom):
    """Another model's four functions."""

    inner: Rom

    def encode(self, x):
        return self.inner.encode(x)

    def decode(self, z):
        return self.inner.decode(z)

    def drift(self, z):
        return self.inner.drift(z)

    def force_map(self, z, p):
        return self.inner.force_map(z, p)


def both(rom, start, times, drive=None):
    return rollout(rom, start, times, Integrator(), drive), rollout(
        Outside(rom.reach, rom), start, times, Integrator(), drive
    )


def test_four_functions_are_enough():
    rom = linear_rom(reach=np.array([0.02, 0.02 * OMEGA]))
    start, times = (
        np.array([[0.005, 0.0], [0.1, 0.0], [0.5, 0.0], [0.02, 1.0]] * 3),
        np.linspace(0, 0.3, 200)[None].repeat(12, axis=0),
    )
    drive = Drive(np.ones(1), np.linspace(0, 2000, 12), OMEGA * np.linspace(0.8, 1.2, 12))
    for signal in (None, drive):
        ours, slow = both(rom, start, times, signal)
        limit = 10 * rom.reach
        assert ours.outcome == slow.outcome and set(ours.outcome) >= {"diverged", "left_range"}
        np.testing.assert_allclose(ours.reduced / limit, slow.reduced / limit, rtol=0, atol=1e-9)
        np.testing.assert_allclose(ours.failed_at, slow.failed_at, rtol=1e-6)
        # Peaks are those of step ends, whose places hang on the last digits of error estimates.
        np.testing.assert_allclose(ours.range_ratio, slow.range_ratio, rtol=1e-5)
    reduced = ours.reduced[0]
    assert np.array_equal(
        decode_displacement(rom, reduced, np.array([0]), chunk=64),
        decode_displacement(Outside(rom.reach, rom), reduced)[:, :1],
    )


@pytest.mark.parametrize(
    "reach", [[1.0], [1.0, 2.0, 3.0], [], [[1.0, 2.0]], [1.0, 0.0], [1.0, np.nan]]
)
def test_a_reach_that_is_not_of_positions_and_velocities_is_refused(reach):
    with pytest.raises(
        MethodError,
        match="Outside.reach is .*; give the largest of d reduced positions, then of their d velocities",
    ):
        Outside(np.array(reach), linear_rom())


def test_a_stored_model_moves_as_the_one_that_was_stored():
    rom, start, times = linear_rom(), np.array([[0.5, 0.0]]), np.linspace(0, 0.1, 50)[None]
    again = rom_from_dataset(rom.to_dataset())
    assert np.array_equal(
        rollout(again, start, times, Integrator()).reduced,
        rollout(rom, start, times, Integrator()).reduced,
    )


PROCESS = """
import sys
import vibrom.latent.autoencoder_rom, vibrom.latent.polynomial_rom, vibrom.models.rollout
assert "numba" not in sys.modules, "a model that is not rolled out imports a compiler"
from vibrom.latent import decoder_kernel, polynomial_kernel
from vibrom.solvers.reduced import dop853_loop
compiled = decoder_kernel._force, polynomial_kernel._polynomial, polynomial_kernel._constant, dop853_loop._compiled
print("torch" in sys.modules, sum(sum(item.stats.cache_misses.values()) for item in compiled), sum(sum(item.stats.cache_hits.values()) for item in compiled))
"""


def test_a_second_process_compiles_nothing_and_no_model_imports_torch():
    from vibrom.latent import decoder_kernel  # noqa: F401  compiled by now, if it was not
    from vibrom.solvers import dop853_loop  # noqa: F401

    done = subprocess.run([sys.executable, "-c", PROCESS], capture_output=True, text=True)
    assert done.stdout.split() == ["False", "0", "4"], done.stderr


@pytest.mark.parametrize("rtol", [1e-4, 1e-6, 1e-8, 1e-10])
def test_the_error_follows_the_tolerance(rtol):
    """x'' + c x' + w^2 x = 0 from 1: thirty periods, exact in closed form."""
    times = np.linspace(0, 30 * 2 * np.pi / OMEGA, 300)[None]
    run = rollout(linear_rom(), np.array([[1.0, 0.0]]), times, Integrator(rtol, rtol / 100))
    damped = np.sqrt(OMEGA**2 - 16.0)
    exact = np.exp(-4.0 * times) * (np.cos(damped * times) + 4.0 / damped * np.sin(damped * times))
    # Some three hundred steps, each within the tolerance; none much better than it.
    assert rtol / 100 < np.abs(run.reduced[..., 0] - exact).max() < 300 * rtol
