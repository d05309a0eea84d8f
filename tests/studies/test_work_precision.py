"""Orders, fronts, cheapest settings and break-even against their definitions, by brute force."""

import numpy as np
import pytest

from vibrom.studies.parts.timing import repeated
from vibrom.studies.parts.work_precision import break_even, cheapest, front, observed_order


@pytest.mark.parametrize("order", [1.0, 2.0, 4.0])
def test_order_of_a_power_law_between_the_reference_and_what_has_not_converged(order):
    size = 0.5 ** np.arange(8)
    error = 3.0 * size**order
    assert observed_order(size, error) == pytest.approx(order, abs=1e-12)
    spoilt = np.maximum(error, 2 * error[-2])  # a reference that is no better than this
    spoilt[0] = 1e3
    assert observed_order(size, spoilt, floor=2.1 * error[-2], ceiling=100.0) == pytest.approx(
        order, abs=1e-12
    )
    assert np.isnan(observed_order(size, np.full(8, np.nan))) and np.isnan(
        observed_order(size[:1], error[:1])
    )


def test_front_and_cheapest_by_brute_force():
    random = np.random.default_rng(1)
    cost, error = random.integers(1, 12, (2, 60)).astype(float)  # with ties
    cost[:5], error[5:10] = np.nan, np.nan
    beaten = [
        any(
            c <= cost[i] and e <= error[i] and (c < cost[i] or e < error[i])
            for c, e in zip(cost, error)
        )
        for i in range(60)
    ]
    on_front = {
        (cost[i], error[i])
        for i in range(60)
        if not beaten[i] and np.isfinite([cost[i], error[i]]).all()
    }
    found = front(cost, error)
    assert {(cost[i], error[i]) for i in found} == on_front and list(cost[found]) == sorted(
        cost[found]
    )
    for target in (0.5, 1.0, 4.0):
        good = [cost[i] for i in range(60) if error[i] <= target and np.isfinite(cost[i])]
        chosen = cheapest(cost, error, target)
        assert (chosen is None) == (not good) and (
            chosen is None or (cost[chosen] == min(good) and error[chosen] <= target)
        )
    assert len(front(np.full(3, np.nan), np.ones(3))) == 0


@pytest.mark.parametrize(
    "offline, online, full",
    [(10.0, 0.1, 2.0), (3.0, 1.0, 2.0), (0.0, 1.0, 2.0), (5903.2 + 1228.3, 0.2, 1228.3)],
)
def test_break_even_by_counting(offline, online, full):
    count = next(k for k in range(1, 1000) if offline + k * online <= k * full)
    assert break_even(offline, online, full) == count


def test_break_even_that_never_comes_and_that_is_not_known():
    assert break_even(1.0, 2.0, 2.0) == np.inf and np.isnan(break_even(np.nan, 1.0, 2.0))


def test_medians_of_repeated_calls_until_patience_ends():
    seconds = iter([9.0, 1.0, 2.0, 3.0])
    assert repeated(lambda: ("answer", next(seconds)), repeats=3, patience=100.0) == (
        "answer",
        2.0,
        3,
    )
    assert repeated(lambda: ("answer", 3.0), repeats=5, patience=5.0) == ("answer", 3.0, 2)
