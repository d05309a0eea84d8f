"""The pieces of the experiments against closed forms: amplitude and phase, NMTE, backbone,
eigenvalues, rollouts and their outcomes.
"""

import numpy as np
import pytest
import xarray as xr
from oscillators import DAMPING, OMEGA, linear_rom

from vibrom.experiments.backbone import peak_finding_and_fitting
from vibrom.experiments.decay import Decay
from vibrom.models.measures import (
    backbone_error,
    crossings,
    curve_error,
    nmte_percent,
    periodic,
    response_variables,
)
from vibrom.models.recorded import differences
from vibrom.models.rollout import Drive, Integrator, rollout


def test_amplitude_and_phase_of_a_harmonic():
    x = 2 * np.pi * np.arange(1000) / 1000
    for lag in (-0.3, -1.5, -3.0, -4.5):
        shown = periodic(2.0 * np.sin(x + lag))
        # The maximum may lie half a sample off: (pi/1000)^2/2.
        assert shown.maximum == pytest.approx(2.0, rel=1e-5)
        assert shown.phase == pytest.approx(lag, abs=1e-12)


def test_amplitude_is_the_maximum_and_the_range_tells_the_swing():
    """A point that swings far to one side: its maximum says little, its range all."""
    x = 2 * np.pi * np.arange(1000) / 1000
    shown = periodic(0.7 * np.sin(x) - 0.7)
    assert shown.maximum == pytest.approx(0.0, abs=1e-5)
    assert shown.minimum == pytest.approx(-1.4, rel=1e-5)
    assert shown.half_range == pytest.approx(0.7, rel=1e-5)


def test_nmte_by_hand():
    truth = np.array([[3.0, 4.0], [0.0, 0.0], [0.0, 1.0]])
    model = truth + np.array([[0.6, 0.8], [0.5, 0.0], [0.0, 0.0]])
    assert nmte_percent(truth, model) == pytest.approx(100 * 0.5 / 5.0)
    model[1] = np.nan
    assert np.isnan(nmte_percent(truth, model))


def test_errors_of_a_curve_by_hand():
    truth = np.array([1.0, 2.0, 4.0, np.nan])
    whole = curve_error(np.array([1.1, 1.9, 4.8, 1.0]), truth)
    assert (whole.median_percent, whole.completed) == (pytest.approx(10.0), 4)
    assert whole.largest_percent == pytest.approx(20.0)
    assert np.isnan(whole.peak_percent)  # of a truth with a gap
    truth = truth[:3]
    peak = curve_error(np.array([1.0, 4.4, 4.0]), truth)
    assert (peak.peak_percent, peak.peak_steps) == (pytest.approx(10.0), 1)
    lost = curve_error(np.array([1.0, np.nan, np.nan]), truth)
    assert (lost.median_percent, lost.largest_percent, lost.completed) == (np.inf, np.inf, 1)


def test_crossings_of_a_line_are_exact():
    time = np.array([0.0, 1.0, 3.0, 4.0])
    instants, before = crossings(time, np.array([1.0, -1.0, 3.0, 1.0]))
    np.testing.assert_allclose(instants, [0.5, 1.5])
    assert before.tolist() == [0, 1]
    assert len(crossings(time, np.array([1.0, np.nan, -1.0, 1.0]))[0]) == 0


def test_backbone_of_a_linear_decay():
    """x = A e^{-zeta omega t} cos(omega_d t): the frequency is omega_d everywhere, the damping zeta
    omega / omega_d.
    """
    omega, zeta = 400.0, 0.01
    damped, t = omega * np.sqrt(1 - zeta**2), np.linspace(0, 0.4, 6001)
    amplitude, frequency, damping, *_ = peak_finding_and_fitting(
        t, 0.3 * np.exp(-zeta * omega * t) * np.cos(damped * t)
    )
    # Linear interpolation of the crossings errs by (omega dt)^2 of a sample, 1e-5 of a period; the
    # parabola by its fourth power.
    np.testing.assert_allclose(frequency, damped, rtol=1e-4)
    np.testing.assert_allclose(damping, zeta, rtol=2e-2)
    assert np.all(np.diff(amplitude) < 0) and 0.25 < amplitude[0] < 0.3


def test_a_mean_lies_within_its_interval_of_95_percent():
    """Of a steady motion with noise of 0.5 % at the peaks and crossings, whose means are known; the
    share of 240 windows that hold them is 95 %, or more as neighbouring half periods err against
    one another.
    """
    t, hits = np.linspace(0, 3.0, 60001), []
    for seed in range(4):
        noise = 0.005 * np.random.default_rng(seed).standard_normal((2, 130))
        at = np.arange(130) * np.pi / 400.0
        shifted = 400.0 * t + np.interp(t, at, noise[0])
        x = (1.0 + np.interp(t, at, noise[1])) * np.cos(shifted)
        _, frequency, damping, *sure = peak_finding_and_fitting(t[t < 0.95], x[t < 0.95], 6)
        hits += [np.abs(frequency - 400.0) <= sure[0], np.abs(damping) <= sure[1]]
    shares = [np.concatenate(hits[first::2]).mean() for first in (0, 1)]
    assert min(shares) > 0.92


def test_backbone_of_a_hardening_oscillator():
    """x'' + x + e x^3 = 0: omega = 1 + 3 e A^2/8 - 21 (e A^2)^2/256 + O((e A^2)^3) by Lindstedt's
    series.
    """
    from scipy.integrate import solve_ivp

    e, t = 0.2, np.linspace(0, 100, 40001)
    x = solve_ivp(
        lambda t, y: [y[1], -y[0] - e * y[0] ** 3],
        (0, 100),
        [1.0, 0.0],
        t_eval=t,
        rtol=1e-11,
        atol=1e-12,
    ).y[0]
    amplitude, frequency, *_ = peak_finding_and_fitting(t, x)
    np.testing.assert_allclose(amplitude, 1.0, rtol=1e-5)
    np.testing.assert_allclose(frequency, 1 + 3 * e / 8 - 21 * e**2 / 256, atol=0.4 * e**3)


def test_too_short_a_decay_has_no_backbone():
    found = peak_finding_and_fitting(np.linspace(0, 1, 50), np.ones(50))
    assert [len(part) for part in found] == [0, 0, 0, 0, 0]
    assert np.isnan(backbone_error((np.zeros(0),) * 2, (np.ones(3),) * 2))


def test_errors_of_backbones_do_not_depend_on_where_their_points_are():
    """|y/y_true - 1| = a/10 between 1, where one begins, and 3, where the other one ends: 20 %."""
    random = np.random.default_rng(0)
    for count in (2, 3, 30):
        a, b = (np.sort(random.uniform(*ends, count)) for ends in ((1.0, 4.0), (0.5, 3.0)))
        a[[0, -1]], b[[0, -1]] = (1.0, 4.0), (0.5, 3.0)
        found = backbone_error((a, 1.0 + 0.1 * a), (b, np.ones(count)))
        assert found == pytest.approx(20.0)
    assert backbone_error((np.ones(1), np.full(1, 1.1)), (a, np.ones(30))) == pytest.approx(10.0)
    assert np.isnan(backbone_error((np.zeros(1), np.ones(1)), (a, np.ones(30))))


def test_differences_are_of_sixth_order():
    errors = []
    for count in (40, 80):
        t = np.linspace(0, 2, count + 1)
        velocity, acceleration = differences(np.sin(3 * t)[:, None], t[1] - t[0])
        errors.append(
            (
                np.abs(velocity[:, 0] - 3 * np.cos(3 * t[3:-3])).max(),
                np.abs(acceleration[:, 0] + 9 * np.sin(3 * t[3:-3])).max(),
            )
        )
    np.testing.assert_allclose(np.log2(np.array(errors[0]) / errors[1]), 6.0, atol=0.15)


def test_forced_response_of_a_linear_model():
    """Steady state of  z'' + c z' + w^2 z = A sin(W t):  |z| = A / |w^2 - W^2 + i c W|, phase
    -atan2(c W, w^2 - W^2).
    """
    frequency = OMEGA * np.array([0.8, 0.97, 1.0, 1.2])
    period = (2 * np.pi / frequency)[:, None]
    times = period * (400 + np.arange(201) / 200)  # e^{-c t/2} is below 1e-10 by then
    run = rollout(
        linear_rom(),
        np.zeros((4, 2)),
        times,
        Integrator(),
        Drive(np.array([1.0]), np.full(4, 0.5), frequency),
    )
    shown = periodic(run.reduced[:, :-1, 0])
    response = 0.5 / (OMEGA**2 - frequency**2 + 1j * DAMPING * frequency)
    # 200 samples a period: (pi/200)^2/2
    np.testing.assert_allclose(shown.maximum, np.abs(response), rtol=2e-4)
    # Local errors of 1e-8 add up over the motion's memory of 1/(zeta omega), some thousand steps.
    np.testing.assert_allclose(shown.phase, np.angle(response), atol=1e-5)
    assert run.outcome == ["ok"] * 4


def test_leaving_the_training_range_is_said_and_the_run_goes_on():
    rom = linear_rom(reach=np.array([0.01, 0.01 * OMEGA]))
    run = rollout(
        rom,
        np.array([[0.005, 0.0], [0.05, 0.0]]),
        np.linspace(0, 0.1, 50)[None].repeat(2, axis=0),
        Integrator(),
    )
    assert run.outcome == ["ok", "left_range"]
    assert run.range_ratio == pytest.approx([0.5, 5.0], rel=0.02)
    assert np.isfinite(run.reduced).all() and np.isnan(run.failed_at[0]) and run.failed_at[1] < 0.02


def test_what_a_response_shows_keeps_its_two_sides_apart():
    """y = 1 + 2 sin t is largest at 3 and smallest at -1, in phase with the forcing."""
    angle = 2 * np.pi * np.arange(400) / 400
    found = response_variables(("probe",), periodic(1.0 + 2.0 * np.sin(angle)[None]))
    values = {name: item.values.item() for name, item in found.items()}
    assert values == pytest.approx(
        {"amplitude": 3.0, "minimum": -1.0, "half_range": 2.0, "phase": 0.0}, abs=1e-12
    )
    assert [item.attrs["units"] for item in found.values()] == ["m", "m", "m", "rad"]


def test_a_decay_is_compared_with_the_record_and_with_the_converged_motion_apart():
    """Off by 0.1 from a record of ones, and by a fifth from a converged motion of 1.375."""
    ones, time = np.ones((5, 1)), np.arange(5.0)
    record = dict.fromkeys(("displacement", "velocity", "acceleration"), (("time", "dof"), ones))
    truth = xr.Dataset(record, coords={"time": time})
    answer = xr.Dataset({"displacement": (("time", "dof"), 1.1 * ones)})
    assert Decay().score(answer, truth) == pytest.approx({"nmte_percent": 10.0})
    truth["converged_displacement"] = (("time", "dof"), 1.375 * ones)
    assert Decay().score(answer, truth) == pytest.approx(
        {"nmte_percent": 10.0, "converged_nmte_percent": 20.0}
    )
