"""Numbers of curves with branches, by hand."""

from dataclasses import replace

import numpy as np
import pytest

from vibrom.models.curves import Curve, difference
from vibrom.solvers.periodic.stability import Kind

KINDS = {1: Kind.FOLD, 3: Kind.FOLD, 4: Kind.END}


def folded(shift=0.0, size=1.0):
    """Up to a fold at 4, back to one at 2 and on to 6; the middle part is unstable."""
    frequency = np.array([1.0, 4.0, 3.0, 2.0, 6.0]) + shift
    amplitude = size * np.array([1.0, 3.0, 2.5, 2.0, 1.0])
    kind = np.array([KINDS.get(number, Kind.REGULAR) for number in range(5)])
    stable = np.array([True, True, False, False, True])
    return Curve(np.zeros(5, int), frequency, amplitude, stable, kind)


def single(shift=0.0):
    """One peak, stable everywhere."""
    frequency = np.linspace(7.0, 13.0, 61)
    kind = np.array([Kind.REGULAR] * 60 + [Kind.END])
    stable = np.ones(61, bool)
    return Curve(
        np.zeros(61, int), frequency + shift, 1 / (1 + (frequency - 10.0) ** 2), stable, kind
    )


def test_stable_motions_are_counted_between_the_folds():
    curve = folded()
    assert curve.motions(np.array([1.0, 1.5, 2.5, 3.9, 4.5, 6.0])).tolist() == [1, 1, 2, 2, 1, 1]
    assert curve.bistable_width == pytest.approx(2.0)
    assert single().motions(np.linspace(7, 13, 7)).tolist() == [1] * 7
    assert single().bistable_width == 0.0


def test_a_curve_that_is_shifted_is_off_by_the_shift():
    off = difference(folded(shift=0.1, size=1.02), folded())
    assert off.fold_parameter == pytest.approx(100 * 0.1 / 2.0)
    assert off.fold_amplitude == pytest.approx(2.0)
    assert off.peak_parameter == pytest.approx(100 * 0.1 / 4.0)
    assert off.peak_amplitude == pytest.approx(2.0)
    assert off.bistable_width == pytest.approx(0.0)
    assert off.stable_amplitude == pytest.approx(2.0, abs=0.5)
    assert off.unstable_amplitude == pytest.approx(2.0, abs=0.5)


def test_a_curve_without_the_folds_of_the_true_one_is_infinitely_wrong():
    off = difference(single(), folded())
    assert off.fold_parameter == off.fold_amplitude == np.inf
    assert off.stable_amplitude == off.unstable_amplitude == np.inf
    assert off.bistable_width == pytest.approx(-100.0)
    assert difference(folded(), single()).bistable_width == np.inf


def test_equal_curves_without_folds_differ_by_nothing():
    off = difference(single(), single())
    assert list(vars(off).values()) == [0.0] * 7
    assert difference(single(0.3), single()).stable_amplitude == pytest.approx(0.0, abs=1e-9)


def test_a_peak_that_is_flat_where_the_true_one_is_not_has_no_frequency():
    """1/(1 + x^2) is within a thousandth of its largest up to |x| = 0.03; of points at 0.1 apart
    one is, with two neighbours. Cut off at |x| = 0.15 three are, and at 0.35 seven.
    """
    truth = single()
    assert truth.top == pytest.approx((0.0, 0.2))
    for edge, inside, outside in ((0.15, 0.2, 0.4), (0.35, 0.6, 0.8)):
        flat = replace(truth, amplitude=np.minimum(truth.amplitude, 1 / (1 + edge**2)))
        assert flat.top == pytest.approx((inside, outside))
        off = difference(flat, truth)
        assert np.isnan(off.peak_parameter) == (inside > 0.3)
        assert off.peak_amplitude == pytest.approx(-100 * edge**2 / (1 + edge**2))


def test_a_flat_top_beside_the_true_peak_is_at_a_wrong_frequency():
    """By as much as it was shifted, but for the width of the top."""
    truth = single()
    flat = replace(truth, amplitude=np.minimum(truth.amplitude, 1 / (1 + 0.35**2)))
    inside, about = flat.top
    assert np.isnan(difference(flat, truth).peak_parameter)
    place = truth.parameter[truth.peak]
    for shift in (-3.0 * about, 3.0 * about):
        off = difference(replace(flat, parameter=flat.parameter + shift), truth).peak_parameter
        assert off == pytest.approx(100 * shift / place, abs=100 * about / place)


def test_a_branch_that_ended_early_is_not_whole():
    cut = folded().part(slice(0, 3))
    cut = replace(cut, kind=np.array([Kind.REGULAR, Kind.FOLD, Kind.END]))
    assert difference(cut, folded()).stable_amplitude == np.inf


def test_a_curve_without_motions_is_infinitely_wrong_and_as_a_truth_says_nothing():
    none = Curve(*(np.array([item]) for item in (0, 1.0, np.nan, False, Kind.END)))
    assert set(vars(difference(none, single())).values()) == {np.inf}
    assert np.isnan(list(vars(difference(single(), none)).values())).all()
