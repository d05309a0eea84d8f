"""How seeds become one number."""

import numpy as np
import pandas as pd
import pytest

from vibrom.report.scores import COLUMNS, Scores, seed_label, spread, tally


def test_median_of_odd_and_even_numbers_of_seeds():
    assert spread(np.array([3.0, 1.0, 8.0]), worst=True) == (3.0, 1.0, 8.0)
    assert spread(np.array([2.0, 1.0]), worst=True) == (1.5, 1.0, 2.0)


def test_a_failed_seed_counts_as_infinitely_wrong():
    median, low, high = spread(np.array([3.0, np.nan, 8.0]), worst=True)
    assert (median, low) == (8.0, 3.0) and np.isnan(high)


def test_a_median_seed_that_failed_leaves_no_number():
    median, low, high = spread(np.array([3.0, np.nan]), worst=True)
    assert np.isnan(median) and low == 3.0 and np.isnan(high)
    assert all(np.isnan(spread(np.array([np.nan, np.inf]), worst=True)))


def test_without_a_worst_side_failed_seeds_are_left_out_unless_they_are_half():
    assert spread(np.array([3.0, np.nan, 8.0]), worst=False) == (5.5, 3.0, 8.0)
    assert all(np.isnan(spread(np.array([3.0, np.nan]), worst=False)))


def test_tally():
    assert tally(["ok", "ok"]) == "ok"
    assert tally(["ok", "diverged", "ok"]) == "ok 2, diverged 1"
    assert tally(["diverged", "ok"]) == "ok 1, diverged 1"
    assert tally(["diverged", "left_range", "diverged"]) == "diverged 2, left_range 1"
    assert tally([]) == "not run"


@pytest.mark.parametrize(
    ("written", "label"),
    [
        (0, "seed_0"),
        ("2", "seed_2"),
        (1.0, "seed_1"),
        ("seed_1", "seed_1"),
        (-1, "unseeded"),
        ("unseeded", "unseeded"),
        (np.nan, "unseeded"),
    ],
)
def test_seeds_are_read_however_they_are_written(written, label):
    assert seed_label(written) == label


def test_the_drawn_seed_is_the_middle_one_and_failed_seeds_come_last():
    errors = enumerate((9.0, np.nan, 2.0))
    rows = [
        ("small", "split", seed, "decay", "nmte_percent", value, "percent", 0.1, "ok")
        for seed, value in errors
    ]
    scores = Scores(pd.DataFrame(rows, columns=list(COLUMNS)))
    assert scores.median_seed("small", "split", ["seed_0", "seed_1", "seed_2"]) == "seed_0"
    assert scores.median_seed("small", "split", ["seed_0", "seed_2"]) == "seed_2"


def test_scores_without_a_column_are_refused_by_name():
    with pytest.raises(ValueError, match="no column outcome"):
        Scores(pd.DataFrame({name: [] for name in COLUMNS if name != "outcome"}))
