"""Gauss's implicit method against closed forms, its order, and the explicit method of order eight."""

import numpy as np
import pytest
from oscillators import OMEGA, linear_rom

from vibrom.latent.polynomial import exponents
from vibrom.latent.polynomial_kernel import constant_kernel, polynomial_kernel
from vibrom.models.rollout import Drive, Integrator, rollout
from vibrom.models.training import MethodError
from vibrom.solvers.reduced import dop853_loop
from vibrom.solvers.reduced.field import Field
from vibrom.solvers.reduced.gauss import integrate

POWERS, WIDE = exponents(2, 1, 3), np.full(2, 1e6)


def field(*rows, push=None):
    """Rows of {(i, j): coefficient of y1^i y2^j}."""
    coefficients = [[row.get(tuple(power), 0.0) for power in POWERS.tolist()] for row in rows]
    return Field(
        polynomial_kernel(np.ones(2), POWERS, np.array(coefficients)),
        None if push is None else constant_kernel(np.array([0.0, push])),
    )


def solve(model, start, times, step, **options):
    return integrate(
        model,
        start,
        times,
        **{
            "step": step,
            "rtol": 1e-13,
            "atol": np.full(2, 1e-14),
            "reach": WIDE / 10,
            "limit": WIDE,
        }
        | options,
    )


DUFFING = field({(0, 1): 1.0}, {(1, 0): -1.0, (0, 1): -0.1, (3, 0): -1.0}, push=1.0)


def test_order_four_also_between_the_steps():
    times = np.sort(np.random.default_rng(0).uniform(0, 20, (5, 200)), axis=1)
    start, forcing = (
        np.tile([0.4, 0.0], (5, 1)),
        dict(amplitude=np.linspace(0, 0.5, 5), frequency=np.linspace(0.8, 1.2, 5)),
    )
    explicit = dop853_loop.integrate(
        DUFFING,
        start,
        times,
        rtol=1e-12,
        atol=np.full(2, 1e-14),
        first_step=0.01,
        reach=WIDE,
        limit=WIDE,
        max_steps=100_000,
        **forcing,
    )
    errors = [
        np.abs(solve(DUFFING, start, times, step, **forcing).samples - explicit.samples).max()
        for step in (0.2, 0.1, 0.05, 0.025)
    ]
    assert np.all(
        np.abs(np.log2(np.array(errors[:-1]) / errors[1:])[1:] - 4.0) < 0.25
    )  # the first halving still feels the next order


def test_an_undamped_oscillator_keeps_its_energy_at_any_step():
    model, times = field({(0, 1): 1.0}, {(1, 0): -1.0}), np.array([[2000.0]])
    for step in (0.1, 1.0, 5.0):  # to less than two steps a period; a rounding a step
        end = solve(model, np.array([[1.0, 0.0]]), times, step).last[0]
        assert abs(end @ end - 1.0) < 1e-12 * 2000 / step


def test_a_stiff_damper_is_no_reason_for_short_steps():
    """y1' = y2 and y2' = -1e6 y2 - 1e6 y1 settles on y1' = -y1; explicit steps must stay below
    3e-6.
    """
    result = solve(
        field({(0, 1): 1.0}, {(1, 0): -1e6, (0, 1): -1e6}),
        np.array([[1.0, -1.0]]),
        np.array([[1.0]]),
        0.05,
        rtol=1e-10,
        atol=np.full(2, 1e-10),
    )
    assert (
        result.outcome[0] == "ok"
        and abs(result.last[0, 0] - np.exp(-1.0)) < 1e-5
        and result.steps == 20
    )


def test_a_batch_is_its_runs_one_by_one():
    start = np.random.default_rng(1).uniform(-0.5, 0.5, (11, 2))
    times = np.linspace(0, 1, 30) * np.linspace(3, 9, 11)[:, None]  # every run ends at its own time
    forcing = dict(amplitude=np.linspace(0, 0.4, 11), frequency=np.linspace(0.5, 1.5, 11))
    together = solve(DUFFING, start, times, 0.1, **forcing)
    for k in range(11):
        alone = solve(
            DUFFING,
            start[k : k + 1],
            times[k : k + 1],
            0.1,
            **{name: value[k : k + 1] for name, value in forcing.items()},
        )
        assert (
            np.array_equal(alone.samples[0], together.samples[k])
            and alone.ended_at[0] == together.ended_at[k] == times[k, -1]
        )


def test_runs_that_blow_up_say_how_and_spoil_no_other():
    # y1' = y1^3: from 1 infinite at t = 1/2; from 0.1 at t = 50.
    model = field({(3, 0): 1.0}, {})
    result = solve(model, np.array([[1.0, 0.0], [0.1, 0.0]]), np.tile([0.25, 0.7], (2, 1)), 0.01)
    assert list(result.outcome) == ["no_convergence", "ok"] and 0.45 < result.ended_at[0] < 0.55
    np.testing.assert_allclose(
        result.samples[:, 0, 0], [(1 - 0.5) ** -0.5, (100 - 0.5) ** -0.5], rtol=1e-6
    )
    assert np.isnan(result.samples[0, 1]).all() and result.samples[1, 1, 0] == pytest.approx(
        (100 - 1.4) ** -0.5, rel=1e-9
    )
    low = solve(
        model,
        np.array([[1.0, 0.0]]),
        np.array([[0.7]]),
        0.01,
        limit=np.array([2.0, 2.0]),
        reach=np.array([1.5, 1.5]),
    )
    assert (
        low.outcome[0] == "diverged"
        and low.left_at[0] < low.ended_at[0] < 0.5
        and low.peak[0, 0] > 2.0
    )


def test_as_an_integrator_of_rollouts():
    rom = linear_rom()
    times = np.linspace(0, 20 * 2 * np.pi / OMEGA, 500)[None]
    drive = Drive(np.ones(1), np.array([3000.0]), np.array([1.01 * OMEGA]))
    explicit, implicit = (
        rollout(rom, np.zeros((1, 2)), times, Integrator(1e-10, 1e-12, *how), drive)
        for how in ((), ("gauss", 40))
    )
    # Phase errors of (2 pi/40)^4/4320 a radian add up over 126 radians to 2e-5; the cubic between
    # the steps misses (2 pi/40)^4/384.
    assert (
        np.abs(implicit.reduced - explicit.reduced).max(axis=(0, 1))[0]
        < 5e-5 * np.abs(explicit.reduced[..., 0]).max()
    )
    with pytest.raises(MethodError, match="integrator.method"):
        Integrator(method="euler")

    class Own(type(rom)):
        def field(self, p):
            return None

    own = Own(**{name: getattr(rom, name) for name in rom.__dataclass_fields__})
    with pytest.raises(MethodError, match="set method: dop853"):
        rollout(own, np.zeros((1, 2)), times, Integrator(method="gauss"), drive)
