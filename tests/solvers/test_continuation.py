"""Continuation on problems whose solutions are known in closed form."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from vibrom.artefacts.outcome import Outcome
from vibrom.solvers.periodic import between, continuation
from vibrom.solvers.periodic.continuation import Lost, Pace, Value
from vibrom.solvers.periodic.equations import in_frequency
from vibrom.solvers.periodic.maps import Return
from vibrom.solvers.periodic.response import Orbit, Span, branch, minor_folds
from vibrom.solvers.periodic.stability import Kind


def cubic(x, p, derivative):
    """p = x^3/3 - x and y = x^2 + 2: folds at x = -1 (p = 2/3) and at x = 1 (p = -2/3)."""
    residual = np.array([p - x[0] ** 3 / 3 + x[0], x[1] - x[0] ** 2 - 2.0])
    if not derivative:
        return Value(residual)
    by_x = np.array([[1.0 - x[0] ** 2, 0.0], [-2.0 * x[0], 1.0]])
    return Value(residual, by_x, np.array([1.0, 0.0]))


@pytest.mark.parametrize("newton", [True, False])
def test_a_branch_is_followed_through_its_folds_onto_the_solution(newton):
    pace = Pace(scale=1.0, newton=newton)
    point = continuation.at(cubic, np.array([-2.5, 8.0]), -2.5, pace)
    seen = [point]
    for ahead in continuation.walk(cubic, point, pace):
        seen.append(ahead)
        if ahead.p > 2.5:
            break
    x = np.array([item.x for item in seen])
    p = np.array([item.p for item in seen])
    # Newton's last correction is below 1e-6, what it leaves its square.
    np.testing.assert_allclose(p, x[:, 0] ** 3 / 3 - x[:, 0], atol=1e-10)
    np.testing.assert_allclose(x[:, 1], x[:, 0] ** 2 + 2.0, atol=1e-10)
    assert (np.diff(x[:, 0]) > 0.0).all()
    assert (np.sign(np.diff(p)) != np.sign(np.diff(p))[0]).any()
    turns = [continuation.turning(one, other, pace) for one, other in zip(seen, seen[1:])]
    assert max(turns) <= 2.5 * pace.turn


@pytest.mark.parametrize("apart", [3e-3, 1e-2, 3e-2, 1e-1])
def test_a_branch_is_not_left_where_another_one_nearly_crosses(apart):
    """p x - x^3 + e^(3/2) = 0: where p grows from below, x = 0 bends into the upper half of the
    pitchfork, p = x^2 - e^(3/2)/x; straight ahead, e away, lies the branch with x < 0.
    """

    def problem(x, p, derivative):
        residual = np.array([p * x[0] - x[0] ** 3 + apart**1.5, x[1] - 1.0])
        by_x = np.diag([p - 3.0 * x[0] ** 2, 1.0])
        return Value(residual, by_x, np.array([x[0], 0.0]))

    for turn in (0.1, 0.25, 0.5):
        pace = Pace(scale=0.5, turn=turn, newton=True)
        point = continuation.at(problem, np.array([apart**1.5 / 2.0, 1.0]), -2.0, pace)
        for ahead in continuation.walk(problem, point, pace):
            assert ahead.x[0] > 0.0 and ahead.p > point.p
            point = ahead
            if ahead.p > 2.0:
                break


def test_the_matrix_of_the_last_point_and_one_made_anew_lead_to_the_same_points():
    points = []
    for newton in (True, False):
        pace = Pace(scale=1.0, newton=newton)
        start = continuation.at(cubic, np.array([-2.5, 8.0]), -2.5, pace)
        points.append(continuation.beyond(cubic, start, 0.3, pace))
    np.testing.assert_allclose(points[0].u, points[1].u, atol=1e-10)


def test_derivatives_are_rare_without_newton():
    counted = {True: 0, False: 0}

    def problem(x, p, derivative):
        counted[derivative] += 1
        return cubic(x, p, derivative)

    pace = Pace(scale=1.0)
    point = continuation.at(problem, np.array([-2.5, 8.0]), -2.5, pace)
    walk = continuation.walk(problem, point, pace)
    count = sum(1 for _ in zip(range(20), walk))
    assert counted[True] <= 2 * count < counted[False] + counted[True]


def test_a_value_that_is_rough_is_corrected_further():
    """As where a guess is evaluated in a cruder way: the first evaluations are off."""
    left = [3]

    def problem(x, p, derivative):
        value = cubic(x, p, derivative)
        if left[0] == 0:
            return value
        left[0] -= 1
        return Value(value.residual + 1e-3, value.by_x, value.by_p, rough=True)

    point = continuation.at(problem, np.array([-2.5, 8.0]), -2.5, Pace(scale=1.0, newton=True))
    assert left == [0]
    assert point.p == pytest.approx(point.x[0] ** 3 / 3 - point.x[0], abs=1e-10)


def test_a_root_between_two_points_is_found():
    pace = Pace(scale=1.0, newton=True)
    left = continuation.at(cubic, np.array([-1.2, 3.44]), 1.2 - 1.2**3 / 3, pace)
    right = continuation.beyond(cubic, left, 0.2, pace)
    assert left.tangent[-1] * right.tangent[-1] < 0.0

    def slope(point):
        return point.tangent[-1]

    def close(point):
        return abs(slope(point)) < 1e-5

    found = between.root(cubic, left, right, slope, close, pace)
    assert close(found[0]) and len(found) <= 6
    assert found[0].p == pytest.approx(2.0 / 3.0, abs=1e-10)  # the square of the slope
    assert all(left.arc < item.arc < right.arc for item in found)
    onto = between.onto(cubic, left, found[0], 0.65, pace)
    assert onto.p == pytest.approx(0.65) and onto.x[0] < -1.0


def test_a_matrix_that_is_made_again_may_ask_for_a_larger_correction():
    """Near a fold the matrix of the last point tells too little of how far it is."""
    start = continuation.at(cubic, np.array([-2.5, 8.25]), 2.5 - 2.5**3 / 3, Pace(scale=1.0))
    sizes = iter([1e-7, 1e-6, 1e-7])

    def problem(x, p, derivative):
        value = cubic(x, p, derivative)
        return replace(value, residual=np.array([next(sizes), 0.0]))

    point = continuation.beyond(problem, start, 0.1, Pace(scale=1.0))
    assert point.iterations == 2 and point.arc == pytest.approx(0.1)


def test_no_solution_is_reported_as_lost():
    """p = x^2 ends at p = 0: nothing is found below, and steps cannot become shorter for ever."""

    def problem(x, p, derivative):
        if p < 0.3:
            return Value(np.full(1, np.nan), ok=False)
        return Value(np.array([p - x[0]]), -np.eye(1), np.ones(1))

    pace = Pace(scale=1.0)
    start = continuation.at(problem, np.array([1.0]), 1.0, pace, toward=-1.0)
    seen = []
    with pytest.raises(Lost):
        for ahead in continuation.walk(problem, start, pace):
            seen.append(ahead.p)
    assert 0.3 <= seen[-1] < 0.301


class Map:
    """x -> function(x, p) as a return map."""

    frequency, parts, free = 1.0, 1, True

    def __init__(self, function, slope, by_p):
        self.function, self.slope, self.by_p = function, slope, by_p

    def __call__(self, x, frequency, amplitude, derivative=True):
        end = self.function(x, frequency)
        slopes = np.atleast_2d(self.slope(x, frequency)), self.by_p(x, frequency)
        return Return(end, True, False, *slopes, None)


LOGISTIC = Map(lambda x, p: p * x * (1 - x), lambda x, p: p * (1 - 2 * x), lambda x, p: x * (1 - x))
# x' = p x + x^2 - x^3 about x = 0 crosses at p = 1; shifted so that the size of x is not zero.
PITCHFORK = Map(
    lambda x, p: 1 + p * (x - 1) - (x - 1) ** 3,
    lambda x, p: p - 3 * (x - 1) ** 2,
    lambda x, p: x - 1,
)
# The delayed logistic map loses stability at p = 2, with multipliers e^(+-i pi/3).
DELAYED = Map(
    lambda x, p: np.array([p * x[0] * (1 - x[1]), x[0]]),
    lambda x, p: np.array([[p * (1 - x[1]), -p * x[0]], [1.0, 0.0]]),
    lambda x, p: np.array([x[0] * (1 - x[1]), 0.0]),
)


@pytest.mark.parametrize(
    ("flow", "x", "p", "kind", "place", "multiplier"),
    [
        (LOGISTIC, [0.5], 2.0, Kind.PERIOD_DOUBLING, 3.0, -1.0),
        (PITCHFORK, [1.0], 0.5, Kind.PITCHFORK, 1.0, 1.0),
        (DELAYED, [1 / 3, 1 / 3], 1.5, Kind.TORUS, 2.0, np.exp(1j * np.pi / 3)),
    ],
)
def test_losses_of_stability_are_named_and_placed(flow, x, p, kind, place, multiplier):
    pace = Pace(scale=1.0, newton=True)
    problem = in_frequency(flow, 0.0)
    start = continuation.at(problem, np.array(x, float), p, pace)
    orbits = branch(problem, start, Span(p, place + 0.5, 100, 1e-3), pace, 1)
    (special,) = [orbit for orbit in orbits if orbit.kind not in (Kind.REGULAR, Kind.END)]
    assert special.kind == kind
    assert special.p == pytest.approx(place, abs=5e-3)
    gap = np.abs(special.multipliers[:, None] - [multiplier, np.conj(multiplier)]).min()
    assert gap < 5e-3
    stable = [np.abs(orbit.multipliers).max() < 1.0 for orbit in orbits if orbit is not special]
    assert stable == sorted(stable, reverse=True) and not stable[-1]
    assert orbits[-1].kind == Kind.END and orbits[-1].outcome == Outcome.OK
    assert orbits[-1].p == pytest.approx(place + 0.5)


def test_a_branch_says_how_it_ended():
    pace = Pace(scale=1.0, newton=True)
    problem = in_frequency(LOGISTIC, 0.0)
    start = continuation.at(problem, np.array([0.5]), 2.0, pace)
    short = branch(problem, start, Span(2.0, 2.9, 4, 1e-3), pace, 1)
    assert (len(short), short[-1].outcome) == (4, Outcome.UNFINISHED)

    def broken(x, p, derivative):
        return problem(x, p, derivative) if p < 2.5 else Value(x, ok=False)

    lost = branch(broken, start, Span(2.0, 2.9, 100, 1e-3), pace, 1)
    assert lost[-1].outcome == Outcome.LOST and 2.4 < lost[-1].p < 2.5


def steep(x, p, derivative):
    """x = exp(8 p), which cannot be evaluated near p = 0.75."""
    grown = np.exp(min(8.0 * p, 100.0))
    by_p = np.array([-8.0 * grown])
    stable = SimpleNamespace(multipliers=np.array([0.5 + 0.0j]))
    return Value(x - grown, np.eye(1), by_p, ok=abs(p - 0.75) > 1e-3, details=stable)


def test_an_edge_is_met_between_points_that_are_far_apart():
    """A straight line between them is no guess: at 0.9 it is twice as large as the solution."""
    pace = Pace(scale=1.0, newton=True)
    left, right = (continuation.at(steep, np.exp([8.0 * p]), p, pace) for p in (0.0, 1.0))
    right = replace(right, arc=float(np.linalg.norm((right.u - left.u) / left.scale(pace))))
    found = between.onto(steep, left, right, 0.9, pace)
    assert left.arc < found.arc < right.arc
    # The last correction is below 1e-6, what it leaves its square.
    np.testing.assert_allclose([found.p, found.x[0]], [0.9, np.exp(7.2)], rtol=1e-10)


def test_an_edge_that_cannot_be_met_ends_the_branch():
    pace = Pace(scale=1.0, first=0.7, newton=True)
    start = continuation.at(steep, np.array([1.0]), 0.0, pace)
    last = branch(steep, start, Span(-1.0, 0.75, 50, 0.0), pace, 1)[-1]
    assert last.kind is Kind.END and last.outcome is Outcome.LOST and last.point.p < 0.75


def test_folds_that_are_close_are_minor():
    pace = Pace(scale=1.0, newton=True)
    start = continuation.at(cubic, np.array([-2.5, 8.0]), -2.5, pace)

    def at(p, kind):
        return Orbit(replace(start, p=p), kind)

    kinds = [(1.0, Kind.FOLD), (0.9999, Kind.FOLD), (1.05, Kind.FOLD), (1.03, Kind.FOLD)]
    named = minor_folds([at(*item) for item in kinds], 1e-3)
    assert [orbit.kind for orbit in named] == [Kind.MINOR_FOLD] * 2 + [Kind.FOLD] * 2


@pytest.mark.parametrize("turn", [0.25, 0.05])
def test_a_sharp_fold_is_passed_however_little_a_step_may_turn(turn):
    """p = -K (x - 1)^2: at the fold its radius 1/(2 K) is that of a peak at 0.5 % of damping, and
    steps of 0.05 rad are short for 1.5 rad, which takes 30 of them.
    """

    def tip(x, p, derivative):
        off, sharp = x[0] - 1.0, 1.0 / (2.0 * 0.016)
        return Value(np.array([p + sharp * off**2]), np.array([[2.0 * sharp * off]]), np.ones(1))

    pace = Pace(1.0, turn=turn, newton=True)
    start = continuation.at(tip, np.array([0.7]), -0.09 / 0.032, pace)
    beyond = (point for point in continuation.walk(tip, start, pace) if point.x[0] > 1.2)
    assert next(beyond).p < 0.0


def test_a_walk_that_only_creeps_on_ends():
    """A spiral r = e^(-phi/4) about (1, 1): at the allowed turn its steps are ever shorter."""

    def spiral(x, p, derivative):
        a, b = x[0] - 1.0, p - 1.0
        square, angle = a * a + b * b, np.arctan2(b, a) + 2.0 * np.log(a * a + b * b)
        rate_x, rate_p = (-b + 4.0 * a) / square, (a + 4.0 * b) / square
        r, sine, cosine = np.sqrt(square), np.sin(angle), np.cos(angle)
        by_x = np.array([[a / r * sine + r * cosine * rate_x]])
        by_p = np.array([b / r * sine + r * cosine * rate_p])
        return Value(np.array([r * sine]), by_x, by_p)

    pace = Pace(1.0, first=0.02, newton=True)
    radius = np.exp(-np.pi / 4)  # there phi is pi, and sin(phi + 4 ln r) = 0
    start = continuation.at(spiral, np.array([1.0 - radius]), 1.0, pace, toward=-1.0)
    walked = []
    with pytest.raises(Lost, match="too short"):
        for point in continuation.walk(spiral, start, pace):
            walked.append(np.hypot(point.x[0] - 1.0, point.p - 1.0))
            assert len(walked) < 200
    # A step of 2e-3 at the allowed turn is where r = 8e-3; each further one takes 6 % of r.
    assert 8e-3 * 0.9**40 < walked[-1] < 8e-3
