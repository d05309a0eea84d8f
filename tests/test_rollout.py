"""Rollouts: compiled models and outside ones, which have four functions and no more."""

import subprocess
import sys
from dataclasses import dataclass, replace

import numpy as np
import pytest
from oscillators import DAMPING, OMEGA, linear_rom

from vibrom.artefacts.outcome import Outcome
from vibrom.models.rollout import Drive, Integrator, decode_displacement, rollout
from vibrom.models.rom import Rom, rom_from_dataset
from vibrom.models.training import MethodError
from vibrom.solvers.reduced.arguments import ArgumentError

IMPLICIT = Integrator(1e-10, 1e-12, "gauss", 40)


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


def cubic_rom(coefficient):
    """x'' = -w^2 x - c x' + coefficient x^3."""
    rom = linear_rom(reach=np.array([0.02, 0.02 * OMEGA]))
    powers = np.concatenate([rom.dynamics_powers, [[3, 0]]])
    column = np.array([[0.0], [coefficient * 0.02**3]])
    return replace(
        rom, dynamics=np.concatenate([rom.dynamics, column], axis=1), dynamics_powers=powers
    )


@pytest.mark.parametrize("integrator", [Integrator(), IMPLICIT], ids=["dop853", "gauss"])
@pytest.mark.parametrize("driven", [False, True])
def test_four_functions_are_enough(integrator, driven):
    rom = linear_rom(reach=np.array([0.02, 0.02 * OMEGA]))
    start = np.array([[0.005, 0.0], [0.1, 0.0], [0.5, 0.0], [0.02, 1.0]] * 3)
    times = np.linspace(0, 0.3, 200)[None].repeat(12, axis=0)
    signal = np.linspace(0, 2000, 12), OMEGA * np.linspace(0.8, 1.2, 12)
    drive = Drive(np.ones(1), *signal) if driven else None
    ours, outside = (
        rollout(model, start, times, integrator, drive) for model in (rom, Outside(rom.reach, rom))
    )
    limit = 10 * rom.reach
    assert ours.outcome == outside.outcome
    assert set(ours.outcome) >= {Outcome.DIVERGED, Outcome.LEFT_RANGE}
    assert all(isinstance(outcome, Outcome) for outcome in ours.outcome)
    np.testing.assert_allclose(ours.reduced / limit, outside.reduced / limit, rtol=0, atol=1e-9)
    np.testing.assert_allclose(ours.failed_at, outside.failed_at, rtol=1e-6)
    # Peaks are those of step ends, whose places hang on the last digits of error estimates.
    np.testing.assert_allclose(ours.range_ratio, outside.range_ratio, rtol=1e-5)


def test_displacements_are_a_part_of_the_decoded_state():
    rom, reduced = linear_rom(), np.random.default_rng(0).standard_normal((200, 2))
    assert np.array_equal(
        decode_displacement(rom, reduced, np.array([0]), chunk=64),
        decode_displacement(Outside(rom.reach, rom), reduced)[:, :1],
    )


def test_each_outcome():
    """Within the range, beyond it, beyond ten times it, and a cubic force that pushes outwards so
    hard that an implicit step has no solution.
    """
    start = np.array([[0.01, 0.0], [0.1, 0.0], [0.5, 0.0]])
    times = np.full((3, 1), 0.1)
    run = rollout(linear_rom(reach=np.array([0.02, 0.02 * OMEGA])), start, times, Integrator())
    assert run.outcome == ["ok", "left_range", "diverged"]
    assert np.isnan(run.failed_at[0]) and 0.0 < run.failed_at[1] < 0.1
    assert np.isfinite(run.reduced[:2]).all() and np.isnan(run.reduced[2]).all()
    assert run.range_ratio[0] == pytest.approx(0.5, rel=0.05) and run.range_ratio[2] > 10.0
    softening = cubic_rom(1e3 * OMEGA**2 / 0.02**2)
    for integrator, word in ((Integrator(), "diverged"), (IMPLICIT, "no_convergence")):
        assert rollout(softening, start[1:2], times[:1], integrator).outcome == [word]


@pytest.mark.parametrize("outside", [False, True])
@pytest.mark.parametrize(
    ("start", "times", "signal", "message"),
    [
        (np.zeros((1, 3)), np.ones((1, 1)), None, r"start has shape \(1, 3\); give \(runs, 2\)"),
        (np.zeros((1, 1)), np.ones((1, 1)), None, r"start has shape \(1, 1\); give \(runs, 2\)"),
        (np.zeros(2), np.ones((1, 1)), None, r"start has shape \(2,\); give \(runs, 2\)"),
        (np.full((1, 2), np.nan), np.ones((1, 1)), None, r"start\[0, 0\] is nan"),
        (np.zeros((1, 2)), np.ones(3), None, r"times has shape \(3,\); give \(1, instants\)"),
        (np.zeros((2, 2)), np.ones((1, 3)), None, r"times has shape \(1, 3\); give \(2, instants"),
        (np.zeros((1, 2)), [[1.0, 0.5]], None, r"times\[0, 1\] is 0.5, .* ascending"),
        (np.zeros((1, 2)), [[-1.0, 0.5]], None, r"times\[0, 0\] is -1, .* seconds from 0 on"),
        (np.zeros((1, 2)), np.ones((1, 1)), (np.ones(2), np.ones(1)), r"amplitude has shape \(2,"),
        (np.zeros((1, 2)), np.ones((1, 1)), (np.ones(1), 400.0), r"frequency has shape \(\)"),
    ],
)
def test_what_cannot_be_meant_is_one_clear_error(outside, start, times, signal, message):
    rom = linear_rom()
    rom = Outside(rom.reach, rom) if outside else rom
    drive = None if signal is None else Drive(np.ones(1), *signal)
    with pytest.raises(ArgumentError, match=message):
        rollout(rom, start, times, Integrator(), drive)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"method": "euler"}, "integrator.method is 'euler'; give dop853 or gauss"),
        ({"rtol": 0.0}, "integrator.rtol is 0.0; give a positive number"),
        ({"atol": -1.0}, "integrator.atol is -1.0"),
        ({"steps": 0}, "integrator.steps is 0"),
        ({"rtol": np.nan}, "integrator.rtol is nan"),
    ],
)
def test_an_integrator_that_cannot_be_is_refused(settings, message):
    with pytest.raises(MethodError, match=message):
        Integrator(**settings)


@pytest.mark.parametrize(
    "reach", [[1.0], [1.0, 2.0, 3.0], [], [[1.0, 2.0]], [1.0, 0.0], [1.0, np.nan]]
)
def test_a_reach_that_is_not_of_positions_and_velocities_is_refused(reach):
    with pytest.raises(
        MethodError,
        match="Outside.reach is .*; give the largest of d reduced positions, then of their d vel",
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
from vibrom.solvers.reduced import explicit, functions
from vibrom.solvers.reduced.steppers import gauss
homes = decoder_kernel, polynomial_kernel, explicit, functions, gauss
compiled = {item for home in homes for item in vars(home).values()
            if hasattr(item, "stats") and item.signatures}
misses, hits = (sum(sum(getattr(item.stats, name).values()) for item in compiled)
                for name in ("cache_misses", "cache_hits"))
print("torch" in sys.modules, misses, hits > 5)
"""


def test_a_second_process_compiles_nothing_and_no_model_imports_torch():
    # Compiled by now, if it was not.
    from vibrom.latent import decoder_kernel  # noqa: F401
    from vibrom.solvers.reduced import explicit, functions  # noqa: F401
    from vibrom.solvers.reduced.steppers import gauss  # noqa: F401

    done = subprocess.run([sys.executable, "-c", PROCESS], capture_output=True, text=True)
    assert done.stdout.split() == ["False", "0", "True"], done.stderr


@pytest.mark.parametrize("rtol", [1e-4, 1e-6, 1e-8, 1e-10])
def test_the_error_follows_the_tolerance(rtol):
    """x'' + c x' + w^2 x = 0 from 1: thirty periods, exact in closed form."""
    times = np.linspace(0, 30 * 2 * np.pi / OMEGA, 300)[None]
    run = rollout(linear_rom(), np.array([[1.0, 0.0]]), times, Integrator(rtol, rtol / 100))
    decay = DAMPING / 2
    damped = np.sqrt(OMEGA**2 - decay**2)
    swing = np.cos(damped * times) + decay / damped * np.sin(damped * times)
    # Some three hundred steps, each within the tolerance; none much better than it.
    error = np.abs(run.reduced[..., 0] - np.exp(-decay * times) * swing).max()
    assert rtol / 100 < error < 300 * rtol


def test_the_implicit_method_follows_a_forced_motion():
    rom, start = linear_rom(), np.zeros((1, 2))
    times = np.linspace(0, 20 * 2 * np.pi / OMEGA, 500)[None]
    drive = Drive(np.ones(1), np.array([3000.0]), np.array([1.01 * OMEGA]))
    explicit, implicit = (
        rollout(rom, start, times, integrator, drive).reduced[0, :, 0]
        for integrator in (Integrator(1e-10, 1e-12), IMPLICIT)
    )
    # Phase errors of (2 pi/40)^4/4320 a radian add up over 126 radians to 2e-5; the cubic between
    # the steps misses (2 pi/40)^4/384.
    assert np.abs(implicit - explicit).max() < 5e-5 * np.abs(explicit).max()
