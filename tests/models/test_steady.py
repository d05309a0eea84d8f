"""Steady or not: a damped oscillator whose transient is known."""

from pathlib import Path

import numpy as np
import pytest
import yaml
from oscillators import DAMPING, OMEGA, linear_rom

from vibrom.artefacts.outcome import Outcome
from vibrom.experiments.forced import Forced
from vibrom.experiments.frc import ResponseCurve
from vibrom.models.model import Drive
from vibrom.models.reduced import Reduced
from vibrom.models.rollout import Integrator
from vibrom.models.steady import change, judged, strobe

SCENES = Path(__file__).parents[2] / "config/scenes"
ZETA = DAMPING / (2 * OMEGA)
DAMPED = OMEGA * np.sqrt(1 - ZETA**2)


def model():
    integrator = Integrator(rtol=1e-10, atol=1e-12)
    return Reduced(linear_rom(), np.ones(1), np.zeros(1, int), DAMPED, integrator)


@pytest.mark.parametrize(("periods", "lag"), [(10, 3), (40, 10), (200, 50)])
def test_the_change_is_that_of_the_transient(periods, lag):
    """At resonance from rest x = A (1 - e^(-zeta omega t)) to first order of zeta: `lag` periods
    before the end 1 - x/A was larger by e^(lag zeta omega T).
    """
    drive = Drive(np.ones(1), np.array([DAMPED]))
    watch = strobe(drive.period, periods, 400, np.zeros(1, int))
    run = model().motion(np.zeros((1, 2)), drive, watch)
    left = np.exp(-ZETA * OMEGA * drive.period[0] * np.array([periods, periods - lag]))
    expected = (left[1] - left[0]) / (1 - left[0])
    amplitude = (1 - left[0]) / (2 * ZETA * OMEGA**2)
    found = change(run.displacement[0], np.full((1, 1), amplitude), periods)
    assert found[0] == pytest.approx(expected, rel=0.05, abs=1e-8)


@pytest.mark.parametrize("damping_ratio", [1e-3, 1e-2])
@pytest.mark.parametrize("ratio", [0.83, 0.97, 1.0, 1.07])
def test_what_is_left_of_a_transient_is_not_much_more_than_the_change(damping_ratio, ratio):
    """The exact response from rest, resonant and not, at all lengths of a run: where c is below
    1/20, the amplitude is as close to the steady one. Off resonance the transient turns against the
    forcing, so that a pair of moments may agree by chance; of pairs 1, 2, 4, ... periods apart the
    largest counts.
    """
    frequency = ratio * np.sqrt(1 - damping_ratio**2)
    steady = 1 / (1 - frequency**2 + 2j * damping_ratio * frequency)
    root = complex(-damping_ratio, np.sqrt(1 - damping_ratio**2))
    # x = Im steady e^(i W t) + Re b e^(root t), with x(0) = x'(0) = 0
    parts = np.array([[1.0, 0.0], [root.real, -root.imag]])
    start = [-steady.imag, -(1j * frequency * steady).imag]
    b = np.linalg.solve(parts, start) @ [1, 1j]

    def x(t):
        return (steady * np.exp(1j * frequency * t)).imag + (b * np.exp(root * t)).real

    period, judgements = 2 * np.pi / frequency, 0
    for periods in range(4, 900):
        watch = strobe(np.array([period]), periods, 400, np.zeros(1, int))
        last = np.abs(x(period * (periods - np.arange(400) / 400))).max()
        found = change(x(watch.instants)[:, :, None], np.full((1, 1), last), periods)[0]
        judgements += found < 1 / 20
        # 400 samples find a largest value to (pi/400)^2/2 = 3.1e-5.
        assert found >= 1 / 20 or abs(last / abs(steady) - 1) < 1.5 * found + 3.1e-5
    assert judgements > 100


def test_what_still_changes_is_not_steady_and_keeps_its_value():
    ended = np.array([Outcome.OK, Outcome.OK, Outcome.LEFT_RANGE, Outcome.DIVERGED], dtype=object)
    found = judged(ended, np.array([0.02, 0.001, 0.02, np.nan]), 0.01)
    assert list(found) == ["not_steady", "ok", "not_steady", "diverged"]
    assert Outcome.NOT_STEADY.has_value


def test_short_runs_are_not_judged():
    watch = strobe(np.ones(1), 3, 40, np.zeros(1, int))
    assert watch.instants.min() > 0 and np.isnan(change(np.ones((1, 4, 1)), np.ones((1, 1)), 3))


def test_a_run_of_one_period_has_instants_of_its_own():
    watch = strobe(np.ones(1), 1, 40, np.zeros(1, int))
    assert watch.instants.min() >= 0 and watch.instants.max() == 1.0


@pytest.mark.parametrize("question", [Forced, ResponseCurve])
def test_experiments_take_a_tolerance(question):
    assert question(forcing=1.0).steady == 0.001


@pytest.mark.parametrize("path", sorted(SCENES.glob("*.yaml")), ids=lambda path: path.stem)
def test_forced_runs_of_the_scenes_last_until_they_are_steady(path):
    """c = a exp(-3/4 2 pi zeta N) of N periods, where the transient of a run from rest that is off
    resonance is up to a = 3 times the response; damping by the stiffness would only add to it.
    """
    scene = yaml.safe_load(path.read_text())
    ratio = scene["effects"]["rayleigh_damping"]["damping_ratio"]
    for kind in (Forced, ResponseCurve):
        asked = scene["experiments"].get(kind.__module__.rpartition(".")[2])
        if asked:
            left = 3.0 * np.exp(-1.5 * np.pi * ratio * asked["periods"])
            assert left < kind(**asked).steady, asked
