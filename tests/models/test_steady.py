"""Steady or not: a damped oscillator whose transient is known."""

import numpy as np
import pytest
from oscillators import DAMPING, OMEGA, linear_rom

from vibrom.artefacts.outcome import Outcome
from vibrom.experiments.forced import Forced
from vibrom.experiments.frc import ResponseCurve
from vibrom.models.model import Drive
from vibrom.models.reduced import Reduced
from vibrom.models.rollout import Integrator
from vibrom.models.steady import PERIODS, change, judged, strobe

ZETA = DAMPING / (2 * OMEGA)
DAMPED = OMEGA * np.sqrt(1 - ZETA**2)


def model():
    integrator = Integrator(rtol=1e-10, atol=1e-12)
    return Reduced(linear_rom(), np.ones(1), np.zeros(1, int), DAMPED, integrator)


@pytest.mark.parametrize("periods", [10, 40, 200])
def test_the_change_is_that_of_the_transient(periods):
    """At resonance from rest x = A (1 - e^(-zeta omega t)) to first order of zeta: five periods
    before the end 1 - x/A was larger by e^(5 zeta omega T).
    """
    drive = Drive(np.ones(1), np.array([DAMPED]))
    watch = strobe(drive.period, periods, 400, np.zeros(1, int))
    run = model().motion(np.zeros((1, 2)), drive, watch)
    left = np.exp(-ZETA * OMEGA * drive.period[0] * np.array([periods, periods - PERIODS]))
    expected = (left[1] - left[0]) / (1 - left[0])
    amplitude = (1 - left[0]) / (2 * ZETA * OMEGA**2)
    found = change(run.displacement[0], np.full((1, 1), amplitude), periods)
    assert found[0] == pytest.approx(expected, rel=0.05, abs=1e-8)


def test_what_still_changes_is_not_steady_and_keeps_its_value():
    ended = np.array([Outcome.OK, Outcome.OK, Outcome.LEFT_RANGE, Outcome.DIVERGED], dtype=object)
    found = judged(ended, np.array([0.02, 0.001, 0.02, np.nan]), 0.01)
    assert list(found) == ["not_steady", "ok", "left_range", "diverged"]
    assert Outcome.NOT_STEADY.has_value


def test_short_runs_are_not_judged():
    watch = strobe(np.ones(1), PERIODS, 40, np.zeros(1, int))
    assert watch.instants.min() > 0 and np.isnan(change(np.ones((1, 4, 1)), np.ones((1, 1)), 5))


def test_a_run_of_one_period_has_instants_of_its_own():
    watch = strobe(np.ones(1), 1, 40, np.zeros(1, int))
    assert watch.instants.min() >= 0 and watch.instants.max() == 1.0


@pytest.mark.parametrize("question", [Forced, ResponseCurve])
def test_experiments_take_a_tolerance(question):
    assert question(forcing=1.0).steady == 0.01
