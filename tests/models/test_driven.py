"""Motions under loads with signals of their own, against closed forms, of both kinds of model."""

import dataclasses

import numpy as np
import pytest
import two_dofs
from scipy.integrate import quad
from scipy.signal import lsim

from vibrom.artefacts.outcome import Outcome
from vibrom.latent.polynomial_rom import PolynomialRom
from vibrom.models.model import Drive, Signals, Watch
from vibrom.signals import total


class Plain(PolynomialRom):
    """In numpy alone."""

    def field(self, p):
        return None


def plain():
    exact = two_dofs.reduced()
    fields = {item.name: getattr(exact.rom, item.name) for item in dataclasses.fields(exact.rom)}
    return dataclasses.replace(exact, rom=Plain(**fields))


MODELS = {"full order": two_dofs.full_order, "reduced": two_dofs.reduced}
PERIOD = 2 * np.pi / two_dofs.DAMPED
INSTANTS = PERIOD * np.arange(8 * two_dofs.SAMPLES + 1) / two_dofs.SAMPLES
# The full order takes 400 steps to a period: over eight periods (omega h)^2/12 is an angle of 1e-3
# at the first frequency, and the second one is not far. Reduced steps end at corners of signals.
TOLERANCE = {"full order": 5e-3, "reduced": 2e-6}
BETWEEN = 2e-5  # (omega h)^2/8: what a signal that is linear between instants loses


def motion(model, loads, functions, start=None):
    given = Signals(np.array(loads), lambda t: np.array([[u(t) for u in functions]]))
    start = np.zeros((1, 4)) if start is None else start
    return model.motion(start, given, Watch(INSTANTS))


def modal(response):
    """(m, 2) of `response(frequency, ratio) -> (m,)` to a unit modal load."""
    parts = [
        np.outer(response(omega, zeta), mode) * (mode @ two_dofs.LOAD)
        for omega, zeta, mode in zip(two_dofs.FREQUENCIES, two_dofs.RATIOS, two_dofs.MODES)
    ]
    return sum(parts)


def close(found, true, tolerance):
    assert np.abs(found - true).max() < tolerance * np.abs(true).max()


@pytest.mark.parametrize("kind", MODELS)
def test_the_step_response_of_a_linear_body_is_its_closed_form(kind):
    """z = [1 - e^(-a t) (cos b t + a/b sin b t)]/omega^2."""

    def step(omega, zeta):
        a, b = zeta * omega, omega * np.sqrt(1 - zeta**2)
        swing = np.cos(b * INSTANTS) + a / b * np.sin(b * INSTANTS)
        return (1.0 - np.exp(-a * INSTANTS) * swing) / omega**2

    run = motion(MODELS[kind](), [two_dofs.LOAD], [total({"step": {}})])
    close(run.displacement[0][0], modal(step), TOLERANCE[kind])
    assert run.outcome.tolist() == [Outcome.OK]


@pytest.mark.parametrize("kind", MODELS)
def test_a_blow_is_answered_by_the_integral_of_duhamel(kind):
    """z(t) = int_0^t u(s) e^(-a (t - s)) sin(b (t - s))/b ds, by quadrature."""
    blow = total({"pulse": {"duration": 3.0, "begin": 1.0}})
    places = np.arange(40, len(INSTANTS), 60)

    def answered(omega, zeta):
        a, b = zeta * omega, omega * np.sqrt(1 - zeta**2)

        def kernel(s, t):
            return blow(np.array([s]))[0] * np.exp(-a * (t - s)) * np.sin(b * (t - s)) / b

        ends = [(1.0, min(max(t, 1.0), 4.0), t) for t in INSTANTS[places]]
        return np.array([quad(kernel, begin, end, (t,))[0] for begin, end, t in ends])

    run = motion(MODELS[kind](), [two_dofs.LOAD], [blow])
    close(run.displacement[0][0, places], modal(answered), TOLERANCE[kind] + 2 * BETWEEN)


@pytest.mark.parametrize("kind", MODELS)
def test_two_loads_act_each_with_its_own_signal(kind):
    """Their motions add up where the body is linear."""
    model = MODELS[kind]()
    loads = [two_dofs.LOAD, two_dofs.PULL]
    own = [total(settings) for settings in two_dofs.SIGNALS]
    both = motion(model, loads, own).displacement[0]
    alone = [motion(model, [load], [u]).displacement[0] for load, u in zip(loads, own)]
    # Rounding in some thousand steps; Newton's tolerance is no matter without forces.
    np.testing.assert_allclose(both, sum(alone), atol=1e-11 * np.abs(both).max())


@pytest.mark.parametrize("kind", MODELS)
def test_a_sine_as_a_signal_is_the_sine_of_the_experiments(kind):
    model = MODELS[kind]()
    wave = total({"sine": {"frequency": two_dofs.DAMPED, "amplitude": 0.1}})
    drive = Drive(np.array([0.1]), np.array([two_dofs.DAMPED]))
    true = model.motion(np.zeros((1, 4)), drive, Watch(INSTANTS)).displacement[0]
    close(motion(model, [two_dofs.LOAD], [wave]).displacement[0], true, BETWEEN)


@pytest.mark.parametrize("kind", MODELS)
def test_any_signal_is_that_of_a_linear_simulation(kind):
    """SciPy's, which is exact for a signal that is linear between its instants."""
    noise = total({"noise": {"highest": 1.5, "seed": 3, "lines": 50}})
    fine = np.linspace(0.0, INSTANTS[-1], 40 * (len(INSTANTS) - 1) + 1)

    def simulated(omega, zeta):
        system = ([1.0], [1.0, 2 * zeta * omega, omega**2])
        return lsim(system, noise(fine), fine)[1][::40]

    run = motion(MODELS[kind](), [two_dofs.LOAD], [noise])
    close(run.displacement[0][0], modal(simulated), TOLERANCE[kind] + 5 * BETWEEN)


def test_a_model_in_numpy_moves_as_the_compiled_one():
    loads = [two_dofs.LOAD, two_dofs.PULL]
    own = [total({"sine": {"frequency": 1.0}}), total({"step": {"begin": 1.0}})]
    given = Signals(np.array(loads), lambda t: np.array([[u(t) for u in own]]))
    found, true = (
        model.motion(np.zeros((1, 4)), given, Watch(INSTANTS[:41])).displacement[0]
        for model in (plain(), two_dofs.reduced())
    )
    np.testing.assert_allclose(found, true, atol=1e-12 * np.abs(true).max())


def test_runs_that_diverge_or_leave_the_range_say_when():
    """The exact model with a training range that a step at t = 2 drives it out of."""
    exact = two_dofs.reduced()
    pushed = total({"step": {"begin": 2.0}})
    run = motion(exact, [two_dofs.LOAD], [pushed])
    size = np.abs(run.reduced[0][0, :, 0]).max()
    for share, outcome in ((0.5, Outcome.LEFT_RANGE), (0.05, Outcome.DIVERGED)):
        rom = exact.rom
        reach = np.concatenate([np.full(2, share * size), np.full(2, 100.0)])
        narrow = dataclasses.replace(exact, rom=dataclasses.replace(rom, reach=reach))
        found = motion(narrow, [two_dofs.LOAD], [pushed])
        assert found.outcome.tolist() == [outcome] and 2.0 < found.failed_at[0] < INSTANTS[-1]
        seen = np.isfinite(found.displacement[0][0]).all(axis=1)
        assert seen.all() == (outcome == Outcome.LEFT_RANGE)
        # A shorter training range is a faster time scale, and makes shorter steps.
        true = run.displacement[0][0, seen]
        assert np.abs(found.displacement[0][0, seen] - true).max() < 1e-7 * np.abs(true).max()


def test_runs_of_their_own_seeds_are_those_of_one_seed_each():
    """Nine runs: more than one group of lanes of the reduced model."""
    waves = [total({"noise": {"highest": 1.5, "seed": seed, "lines": 20}}) for seed in range(9)]
    load = two_dofs.LOAD[None]
    for make in MODELS.values():
        model, watch = make(), Watch(INSTANTS[:101])
        every = Signals(load, lambda t: np.array([[u(t)] for u in waves]))
        together = model.motion(np.zeros((9, 4)), every, watch).displacement[0]
        for k in (0, 8):
            alone = Signals(load, lambda t, k=k: waves[k](t)[None, None])
            one = model.motion(np.zeros((1, 4)), alone, watch).displacement[0]
            scale = np.abs(one).max()
            np.testing.assert_allclose(together[k], one[0], atol=1e-12 * scale)
