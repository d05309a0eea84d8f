"""The work balance, on linear motions that are known in closed form."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import two_dofs

from vibrom.effects.dry_friction import DryFriction
from vibrom.experiments.forced import Forced
from vibrom.experiments.frc import ResponseCurve
from vibrom.experiments.random_forcing import RandomForcing
from vibrom.experiments.response import Response
from vibrom.models.balance import SAMPLES, checked, of_motion
from vibrom.models.model import Drive, Signals, Watch
from vibrom.solvers.full.newmark import Newmark

MODEL = two_dofs.full_order()
INSTANTS = MODEL.period * np.arange(20 * SAMPLES + 1) / SAMPLES
START = np.concatenate([two_dofs.START, np.zeros(2)])[None]
REST = np.zeros(2)
DRIVE = Drive(np.array([0.1]), np.array([0.9 * two_dofs.DAMPED]))


def of(displacement, damping=1.0, drive=None, period=MODEL.period):
    term = replace(MODEL.term, damping=damping * MODEL.term.damping)
    return of_motion(term, REST, period, drive, displacement)


def decay():
    """The exact reduced model's, which is linear: integrated to 1e-8."""
    return two_dofs.reduced().motion(START, None, Watch(INSTANTS)).displacement[0][0]


def test_an_exact_decay_balances():
    """To the error of the integrals, H^4/720 of the third derivative of v'Cv, H = T/20, whose
    fastest part has twice the frequency w of the second mode: (2 w H)^4/720 of c E/(2 w).
    """
    w = two_dofs.FREQUENCIES[1]
    bound = (2 * w * MODEL.period / 20) ** 4 / 720 * two_dofs.DAMPING / (2 * w)
    assert of(decay()) < bound < 1e-4


@pytest.mark.parametrize("wrong", [0.9, 1.1])
def test_wrong_damping_by_hand(wrong):
    """The true damping takes what the energy falls by, D; a wrong one would take `wrong` D."""
    q = decay()
    whole = slice(3, -3, SAMPLES)
    velocity = np.gradient(q, INSTANTS, axis=0, edge_order=2)[whole]
    energy = 0.5 * np.einsum("mi,ij,mj->m", q[whole], two_dofs.STIFFNESS, q[whole])
    energy += 0.5 * np.einsum("mi,ij,mj->m", velocity, two_dofs.MASS, velocity)
    taken = energy[0] - energy[-1]
    expected = abs(wrong - 1) * taken / (energy[0] + wrong * taken)
    # np.gradient is of second order: (2 pi/60)^2/6 of the kinetic energy
    assert of(q, damping=wrong) == pytest.approx(expected, rel=1e-2)


def test_work_of_the_load_counts():
    """A run from rest that is driven beside resonance; without its load's work nothing balances."""
    period = DRIVE.period[0]
    instants = period * np.arange(20 * SAMPLES + 1) / SAMPLES
    motion = two_dofs.reduced().motion(0 * START, DRIVE, Watch(instants)).displacement[0][0]
    assert of(motion, drive=DRIVE, period=period) < 1e-5
    stronger = replace(DRIVE, amplitude=1.1 * DRIVE.amplitude)
    assert of(motion, drive=stronger, period=period) > 0.01
    assert of(motion, drive=None, period=period) > 0.3


@pytest.mark.parametrize("alpha", [0.01, 0.05])
def test_numerical_damping_is_what_newmark_is_off_by(alpha):
    """It takes alpha omega h/(2 zeta) of what the damping takes, in the first mode alone."""
    model = replace(MODEL, newmark=Newmark(alpha=alpha), steps_per_period=200)
    start = np.concatenate([two_dofs.MODES[0], np.zeros(2)])[None]
    step, share = model.period / 200, alpha * np.pi / 200 / two_dofs.RATIOS[0]
    found = model.motion(start, None, Watch(step * np.arange(0, 20 * 200 + 1, 200))).balance[0]
    rate = 2 * two_dofs.RATIOS[0] * two_dofs.FREQUENCIES[0] * (1 + share)
    lost = 1 - np.exp(-rate * 20 * model.period)  # of the energy, by both dampings
    taken = lost / (1 + share)
    # The trapezoidal rule's own energy is off by (omega h)^2/8.
    slack = (2 * np.pi / 200) ** 2 / 8
    assert found == pytest.approx(share * taken / (1 + taken), abs=slack, rel=0.01)


def test_runs_side_by_side_are_judged_one_by_one():
    step = 2 * np.pi / np.linspace(0.8, 1.2, 5) / MODEL.steps_per_period
    drive = Drive(np.linspace(0.1, 0.5, 5), 2 * np.pi / step / MODEL.steps_per_period)
    instants = 6 * drive.period[:, None]
    together = MODEL.motion(np.zeros((5, 4)), drive, Watch(instants)).balance
    for one in range(5):
        alone = Drive(*(part[one : one + 1] for part in (drive.amplitude, drive.frequency)))
        found = MODEL.motion(np.zeros((1, 4)), alone, Watch(instants[one])).balance
        np.testing.assert_allclose(found[0], together[one], rtol=1e-6)
    assert len(set(together)) == 5 and (together < 1e-4).all()


@pytest.fixture
def damped_by_mistake(monkeypatch):
    """The integration takes a fifth more damping than the scene has."""

    def run(self, term, *given, own=Newmark.run, **named):
        return own(self, replace(term, damping=1.2 * term.damping), *given, **named)

    monkeypatch.setattr(Newmark, "run", run)


ASKED = (
    Forced(0.1, periods=40),
    ResponseCurve(0.1, 40, 3),
    Response(periods=40),
    RandomForcing(0.1, realisations=3, periods=20, settle=20, windows=1),
)


@pytest.mark.parametrize("question", ASKED)
def test_a_run_that_breaks_it_is_flagged(question, request):
    good = question.ask(MODEL, two_dofs.given())
    assert (good["balance"] < 1e-4).all() and (good["outcome"] != "unbalanced").all()
    request.getfixturevalue("damped_by_mistake")
    wrong = question.ask(MODEL, two_dofs.given())
    assert (wrong["balance"] > 0.1).all() and (wrong["outcome"] == "unbalanced").all()


def test_failures_keep_their_word():
    ended = np.array(["ok", "no_convergence", "ok"], dtype=object)
    found = checked(ended, np.array([0.2, 0.2, np.nan]), 0.01)
    assert list(found) == ["unbalanced", "no_convergence", "ok"]


def test_the_work_of_a_pulse_is_what_there_is_and_what_was_lost():
    """A pulse of U on the first mode, whose step response is known: it works U z(d), and a signal
    that is told to be a tenth larger leaves a tenth of that open.
    """
    omega, zeta, mode = two_dofs.FREQUENCIES[0], two_dofs.RATIOS[0], two_dofs.MODES[0]
    count, end, size = 400, 180, 0.3  # samples of a period, at which the pulse ends, and U
    t = MODEL.period * np.arange(10 * count + 1) / count
    fast, slow = omega * np.sqrt(1 - zeta**2), zeta * omega

    def step_response(t):
        t = np.maximum(t, 0.0)
        turned = np.cos(fast * t) + slow / fast * np.sin(fast * t)
        return size * (1.0 - np.exp(-slow * t) * turned) / omega**2

    def step_speed(t):
        t = np.maximum(t, 0.0)
        return size * np.exp(-slow * t) * np.sin(fast * t) / fast

    z, speed = (f(t) - f(t - t[end]) for f in (step_response, step_speed))
    late = 0.5 * (t[end] + t[end + 1])  # a jump between two samples is a ramp to its reader

    def balance(times):
        pulse = Signals(
            (two_dofs.MASS @ mode)[None],
            lambda at: times * size * np.where(at < late, 1.0, 0.0)[None, None],
        )
        return of_motion(MODEL.term, REST, MODEL.period, pulse, np.outer(z, mode), count)

    # The ramp is off by half a sample's way, h/2 v, of z(d); more than (omega h)^2/12.
    h = MODEL.period / count
    bound = 0.5 * h * abs(speed[end]) / z[end]
    assert balance(1.0) < bound < 0.01
    there = 0.5 * (speed**2 + omega**2 * z**2)  # a unit modal mass
    lost = 2 * slow * np.trapezoid(speed**2, t)
    work = size * z[end]
    before = 2 * slow * np.trapezoid(speed[: end + 1] ** 2, dx=h)
    assert work == pytest.approx(there[end] + before, rel=1e-4)  # (2 omega h)^2/12 of `before`
    expected = 0.1 * work / (there[::count].max() + lost)
    assert balance(1.1) == pytest.approx(expected, rel=0.2 * bound + 0.02)


JUMPS = Signals(
    np.array([two_dofs.LOAD, two_dofs.PULL]),
    lambda t: np.array([[0.2 * (t > 3.3) - 0.3 * (t > 9.1), np.sign(np.sin(40.0 * t))]]),
)


def test_the_trapezoidal_rule_balances_a_linear_body_whatever_drives_it():
    """Each step, but for rounding: signals that jump at every third step and loads that are not
    alike.
    """
    found = MODEL.motion(START, JUMPS, Watch(INSTANTS[:: 2 * SAMPLES])).balance
    assert found[0] < 1e-12


def test_forces_without_a_potential_count_by_their_power():
    """Dry friction stops a slide: it takes all that there was; as the force of a step is the mean
    of its ends, nothing is left open but what Newton's iteration leaves.
    """
    rub = DryFriction([0.0, 0.0], "x", force=0.05, velocity=1e-2)
    rubbed = rub.assemble(SimpleNamespace(dof=lambda *where: 1), MODEL.term)
    close = replace(MODEL, term=MODEL.term + rubbed, newmark=Newmark(tolerance=1e-10))
    watch = Watch(INSTANTS[:: 2 * SAMPLES])
    assert close.motion(START, None, watch).balance[0] < 1e-8
    forgotten = replace(MODEL.term, forces=())
    instants = MODEL.period / 100 * np.arange(20 * 100 + 1)
    motion = close.motion(START, None, Watch(instants)).displacement[0][0]
    assert of_motion(close.term, REST, MODEL.period, None, motion, 100) < 1e-3
    assert of_motion(forgotten, REST, MODEL.period, None, motion, 100) > 0.05


def test_reduced_models_say_nothing_of_it():
    answer = Forced(0.1, periods=4).ask(two_dofs.reduced(), two_dofs.given())
    assert "balance" not in answer
