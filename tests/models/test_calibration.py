"""The strength of a load from one response, against the closed form and against motion in time."""

from dataclasses import replace

import numpy as np
import pytest

from vibrom.latent.polynomial_rom import PolynomialRom
from vibrom.models.calibration import Calibration
from vibrom.models.model import Drive, Watch
from vibrom.models.reduced import Reduced
from vibrom.models.rollout import Integrator
from vibrom.models.training import Unsupported

OMEGA, DAMPING = 10.0, 0.6  # rad/s, 1/s


def oscillator(cubic):
    """z'' = -omega^2 z - c z' - cubic z^3 + 2 p u; two displacements, z and z/2."""
    powers = np.array([[1, 0], [0, 1], [3, 0]])
    dynamics = np.array([[0.0, 1.0, 0.0], [-(OMEGA**2), -DAMPING, -cubic]])
    decoder = np.kron(np.eye(2), [[1.0], [0.5]])
    return PolynomialRom(
        reach=np.array([1.0, OMEGA]),
        encoder=np.array([[1.0, 0.0]]),
        scale=np.ones(2),
        decoder=decoder,
        decoder_powers=np.eye(2, dtype=int),
        dynamics=dynamics,
        dynamics_powers=powers,
        force=np.array([[2.0, 0.0]]),
    )


@pytest.mark.parametrize("frequency", [8.0, 10.0, 12.0])
def test_a_linear_oscillator_has_the_known_strength(frequency):
    """A sqrt((omega^2 - Omega^2)^2 + (c Omega)^2)/2 of z; y = z/2 is measured. Its largest value is
    sought at 256 instants: (pi/256)^2/2 = 8e-5.
    """
    found = Calibration(frequency, 0.1, dof=1).strength(oscillator(0.0), np.array([1.0, 0.0]))
    push = np.hypot(OMEGA**2 - frequency**2, DAMPING * frequency)
    assert found == pytest.approx(0.2 * push / 2.0, rel=1e-4)


@pytest.mark.parametrize("frequency", [9.0, 11.0, 11.5])
def test_a_hardening_oscillator_driven_so_strongly_swings_as_far_as_was_measured(frequency):
    """Released on the motion that was found: on the upper branch, which is stable there."""
    rom, load, amplitude = oscillator(60.0), np.array([1.0, 0.0]), 0.9
    calibration = Calibration(frequency, amplitude, dof=0)
    model = Reduced(rom, load, np.array([0]), OMEGA, Integrator(), calibration=calibration)
    strength = model.known_load[0]
    assert strength == calibration.strength(rom, load)
    period = 2 * np.pi / frequency
    starts = np.array([[a, 0.0, v, 0.0] for a in (-0.9, 0.0, 0.9) for v in (-9.0, 0.0, 9.0)])
    instants = period * (60 + np.arange(401) / 400)
    drive = Drive(np.ones(len(starts)), np.full(len(starts), frequency))
    run = model.motion(starts, drive, Watch(instants, np.array([0])))
    swings = 0.5 * np.ptp(run.displacement[0][..., 0], axis=1)
    assert np.abs(swings / amplitude - 1.0).min() < 2e-4


def test_a_load_that_moves_nothing_cannot_be_calibrated():
    with pytest.raises(Unsupported, match="does not move the first coordinate"):
        Calibration(9.0, 0.1, dof=0).strength(oscillator(0.0), np.array([0.0, 1.0]))


def test_a_channel_that_does_not_move_calibrates_nothing():
    still = replace(oscillator(0.0), decoder=np.kron(np.eye(2), [[1.0], [0.0]]))
    with pytest.raises(Unsupported, match="channel does not move with the model's first"):
        Calibration(9.0, 0.1, dof=1).strength(still, np.array([1.0, 0.0]))


def test_a_motion_that_does_not_balance_calibrates_nothing(monkeypatch):
    monkeypatch.setattr("vibrom.models.calibration.ACCEPTED", 0.0)
    with pytest.raises(Unsupported, match="no response of 0.9 m at 11 rad/s"):
        Calibration(11.0, 0.9, dof=0).strength(oscillator(60.0), np.array([1.0, 0.0]))
