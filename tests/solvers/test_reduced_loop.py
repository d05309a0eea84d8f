"""What the loop over time does whatever the method: runs, samples, events, bounds and outcomes."""

import numpy as np
import pytest
from vector_fields import DUFFING, EXPLICIT, IMPLICIT, OSCILLATOR, SQUARE, solve

from vibrom.solvers.reduced.arguments import ArgumentError
from vibrom.solvers.reduced.functions import field_of
from vibrom.solvers.reduced.integrate import Stepper

BOTH = pytest.mark.parametrize("stepper", [EXPLICIT, IMPLICIT], ids=["explicit", "implicit"])


@BOTH
def test_a_run_is_the_same_alone_and_in_a_queue_to_the_last_bit(stepper):
    rng = np.random.default_rng(2)
    start = rng.uniform(-2, 2, (21, 2))
    amplitude, frequency = rng.uniform(0, 1, 21), rng.uniform(0.5, 2, 21)
    # Lanes fall free at different times.
    times = np.linspace(0, 1, 50) * rng.uniform(5, 30, 21)[:, None]
    together = solve(stepper, DUFFING, start, times, forcing=(amplitude, frequency))
    for k in range(21):
        one = slice(k, k + 1)
        signal = amplitude[one], frequency[one]
        alone = solve(stepper, DUFFING, start[one], times[one], forcing=signal)
        for name, values in alone._asdict().items():
            assert np.array_equal(getattr(together, name)[one], values, equal_nan=True), name


@BOTH
def test_events_end_one_run_and_no_other(stepper):
    """y' = y^2 from 1 is 1/(1 - t): 5 at t = 0.8, 50 at t = 0.98; from -1 it is -1/(1 + t)."""
    start = np.where(np.arange(12) % 3 == 1, 1.0, -1.0)[:, None]
    times = np.linspace(0, 2, 50)[None].repeat(12, axis=0)
    result = solve(stepper, SQUARE, start, times, reach=5.0, limit=50.0)
    quiet = solve(stepper, SQUARE, start[:1], times[:1], reach=5.0, limit=50.0)
    for k in range(12):
        if k % 3 != 1:
            assert result.outcome[k] == "ok" and np.isnan(result.left_at[k])
            assert np.array_equal(result.samples[k], quiet.samples[0])
            continue
        # The implicit steps of 0.05 fly past the pole.
        assert result.outcome[k] in ("diverged", "no_convergence")
        assert 0.8 <= result.left_at[k] <= result.ended_at[k] < 1.05
        assert result.peak[k, 0] == abs(result.last[k, 0])
        known = times[k] <= result.ended_at[k]
        assert np.isfinite(result.samples[k, known]).all()
        assert np.isnan(result.samples[k, ~known]).all()
    np.testing.assert_allclose(quiet.samples[0, :, 0], -1 / (1 + times[0]), rtol=1e-6)


def test_the_explicit_method_diverges_where_the_closed_form_does():
    result = solve(EXPLICIT, SQUARE, np.ones((1, 1)), np.array([[2.0]]), reach=5.0, limit=50.0)
    assert result.outcome == ["diverged"] and 0.98 <= result.ended_at[0] < 1.0
    assert result.last[0, 0] == pytest.approx(1 / (1 - result.ended_at[0]), rel=1e-6)


@BOTH
def test_a_field_that_ends_is_an_outcome(stepper):
    """The first coordinate is time; beyond one half there is no rate."""

    def wall(y):
        return np.stack([np.ones(len(y)), np.where(y[:, 0] < 0.5, 1.0, np.nan)], axis=1)

    with field_of(2, wall) as field:
        result = solve(
            stepper, field, np.array([[0.0, 0.0], [-2.0, 0.0]]), np.array([[0.1, 1.0]] * 2)
        )
    failed = "step_underflow" if stepper is EXPLICIT else "no_convergence"
    assert result.outcome == [failed, "ok"]
    # A step may end a shade before the wall, never beyond it.
    assert 0.44 < result.ended_at[0] <= 0.5 and np.isfinite(result.last).all()
    np.testing.assert_allclose(result.samples[:, :, 1], [[0.1, np.nan], [0.1, 1.0]])


@BOTH
def test_a_field_that_jumps_ends_with_an_outcome(stepper):
    """y' = -sign(y) slides along 0, where no step is short enough for an error estimate."""
    with field_of(1, lambda y: -np.sign(y)) as field:
        result = solve(
            stepper, field, np.array([[0.52], [-3.0]]), np.array([[1.0]] * 2), 1e-8, 1e-8
        )
    assert result.outcome[0] in ("ok", "step_underflow", "no_convergence")
    assert abs(result.last[0, 0]) < 0.06 and result.ended_at[0] > 0.45
    assert result.outcome[1] == "ok" and result.last[1, 0] == pytest.approx(-2.0, abs=1e-7)


def test_a_run_that_crawls_is_stopped():
    few = Stepper(
        EXPLICIT.solve,
        EXPLICIT.method,
        lambda end: (np.full(len(end), 0.05), np.full(len(end), 20)),
    )
    times = np.array([[1000.0], [0.1]])
    result = solve(few, OSCILLATOR, np.array([[1.0, 0.0], [0.0, 0.0]]), times)
    assert result.outcome == ["step_underflow", "ok"]


def test_whether_a_run_crawls_does_not_depend_on_the_batch():
    start, times = np.array([[1.0, 0.0]] * 2), np.array([[0.3], [3000.0]])
    alone = EXPLICIT.plan(times[:1, -1])[1]
    assert EXPLICIT.plan(times[:, -1])[1][0] == alone[0]
    assert solve(EXPLICIT, OSCILLATOR, start, times).outcome == ["ok", "ok"]


@BOTH
def test_first_and_last_instants(stepper):
    times = np.array([[0.0, 0.0, 0.5, 1.0, 1.0], [0.0, 0.0, 0.0, 0.0, 0.0]])
    start = np.array([[1.0, 0.0], [3.0, 4.0]])
    result = solve(stepper, OSCILLATOR, start, times)
    assert np.array_equal(result.samples[0, :2], start[:1].repeat(2, axis=0))
    np.testing.assert_allclose(result.samples[0, 3], result.last[0], rtol=1e-14)
    assert np.array_equal(result.samples[0, 3], result.samples[0, 4])
    assert np.array_equal(result.samples[1], start[1:].repeat(5, axis=0))
    assert result.outcome == ["ok", "ok"] and np.array_equal(result.ended_at, [1.0, 0.0])


@BOTH
def test_no_run_is_no_trouble(stepper):
    result = solve(stepper, OSCILLATOR, np.zeros((0, 2)), np.zeros((0, 3)))
    assert result.samples.shape == (0, 3, 2) and result.outcome == []


@BOTH
def test_python_functions_are_a_vector_field(stepper):
    """The same steps as compiled, to the digits that another order of sums leaves."""

    def drift(y):
        return np.stack([y[:, 1], -y[:, 0] - 0.1 * y[:, 1] - y[:, 0] ** 3], axis=1)

    def force(y):
        return np.tile([0.0, 1.0], (len(y), 1))

    start, times = np.random.default_rng(0).uniform(-1, 1, (11, 2)), np.linspace(0, 30, 200)
    times, forcing = np.tile(times, (11, 1)), (np.linspace(0, 1, 11), np.linspace(0.5, 2.0, 11))
    ours = solve(stepper, DUFFING, start, times, forcing=forcing)
    with field_of(2, drift, force) as field:
        outside = solve(stepper, field, start, times, forcing=forcing)
    assert np.array_equal(ours.steps, outside.steps)
    np.testing.assert_allclose(ours.samples, outside.samples, rtol=0, atol=1e-9)
    np.testing.assert_allclose(ours.peak, outside.peak, rtol=1e-6)


@BOTH
@pytest.mark.parametrize(
    ("fails", "message"),
    [(lambda y: 1 / 0, "division by zero"), (lambda y: y[:, :1][:3], "could not broadcast")],
)
def test_what_a_python_function_raises_is_raised(stepper, fails, message):
    with pytest.raises((ZeroDivisionError, ValueError), match=message), field_of(2, fails) as field:
        solve(stepper, field, np.ones((3, 2)), np.ones((3, 1)))


@BOTH
def test_a_tangent_flow_is_another_vector_field(stepper):
    """y and the columns of its derivative by the start, Phi' = (df/dy) Phi, in one state: the loop
    needs no change, and bounds of infinity leave Phi alone.
    """

    def extended(state):
        y, phi = state[:, :2], state[:, 2:].reshape(-1, 2, 2)
        zero, one = np.zeros(len(y)), np.ones(len(y))
        jacobian = np.stack([zero, one, -1.0 - 3.0 * y[:, 0] ** 2, -0.1 * one], axis=1)
        rate = np.stack([y[:, 1], -y[:, 0] - y[:, 0] ** 3 - 0.1 * y[:, 1]], axis=1)
        return np.concatenate([rate, (jacobian.reshape(-1, 2, 2) @ phi).reshape(-1, 4)], axis=1)

    base, nudge = np.array([0.7, -0.2]), 1e-5
    times = np.array([[6.0]])
    with field_of(6, extended) as field:
        start = np.concatenate([base, np.eye(2).ravel()])[None]
        found = solve(stepper, field, start, times, 1e-12, 1e-13, reach=np.inf, limit=np.inf)
    phi = found.last[0, 2:].reshape(2, 2)
    around = base + nudge * np.array([[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]])
    signal = np.zeros(4), np.ones(4)
    ends = solve(stepper, DUFFING, around, times.repeat(4, 0), 1e-13, 1e-14, forcing=signal).last
    differences = np.stack([ends[0] - ends[1], ends[2] - ends[3]], axis=1) / (2 * nudge)
    np.testing.assert_allclose(phi, differences, atol=1e-8)
    # Liouville: the determinant falls with the damping alone, but for the error of the method.
    assert np.linalg.det(phi) == pytest.approx(np.exp(-0.6), rel=1e-7)


def test_a_force_without_its_signal_is_refused():
    with pytest.raises(ArgumentError, match="needs the amplitude and frequency of each run"):
        solve(EXPLICIT, DUFFING, np.zeros((1, 2)), np.ones((1, 1)))


ROWS = np.tile(np.linspace(0.0, 1.0, 5), (3, 1))
LINE, OK = np.zeros(3), np.zeros((3, 2))


@pytest.mark.parametrize(
    ("start", "times", "amplitude", "frequency", "message"),
    [
        (np.zeros((3, 3)), ROWS, LINE, LINE, r"start has shape \(3, 3\); give \(runs, 2\)"),
        (np.zeros(2), ROWS, LINE, LINE, r"start has shape \(2,\); give \(runs, 2\)"),
        (np.where(OK == 0, np.nan, 0), ROWS, LINE, LINE, r"start\[0, 0\] is nan"),
        (OK + 1j, ROWS, LINE, LINE, "start is complex"),
        ([["a", "b"]] * 3, ROWS, LINE, LINE, "start is no array of numbers"),
        (OK, ROWS[0], LINE, LINE, r"times has shape \(5,\); give \(3, instants\)"),
        (OK, ROWS[:2], LINE, LINE, r"times has shape \(2, 5\); give \(3, instants\)"),
        (OK, ROWS[:, :0], LINE, LINE, r"times has shape \(3, 0\); give \(3, instants\)"),
        (OK, -ROWS, LINE, LINE, r"times\[0, 1\] is -0.25, .* give seconds from 0 on"),
        (OK, np.nan * ROWS, LINE, LINE, r"times\[0, 0\] is nan"),
        (OK, np.inf + ROWS, LINE, LINE, r"times\[0, 0\] is inf"),
        (OK, ROWS[:, ::-1], LINE, LINE, r"times\[0, 1\] is 0.75, .* in ascending order"),
        (OK, ROWS, 1.0, LINE, r"amplitude has shape \(\); give \(3,\)"),
        (OK, ROWS, np.zeros(1), LINE, r"amplitude has shape \(1,\); give \(3,\)"),
        (OK, ROWS, LINE, np.zeros((3, 1)), r"frequency has shape \(3, 1\); give \(3,\)"),
        (OK, ROWS, np.array([0, np.inf, 0]), LINE, r"amplitude\[1\] is inf"),
        (OK, ROWS, LINE, np.array([0, 0, np.nan]), r"frequency\[2\] is nan"),
    ],
)
def test_shapes_and_values_that_cannot_be_meant_are_refused(
    start, times, amplitude, frequency, message
):
    with pytest.raises(ArgumentError, match=message):
        solve(EXPLICIT, DUFFING, start, times, forcing=(amplitude, frequency))
