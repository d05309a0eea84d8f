"""How seeds become one number, and what the numbers of a run are."""

from itertools import product

import numpy as np
import pytest

from vibrom.artefacts.files import DataError
from vibrom.artefacts.outcome import Tally
from vibrom.report.scores import Score, Scores, spread


def rows(*errors, experiment="decay", outcomes=None):
    """Of one method, by seed."""
    words = outcomes or ["ok"] * len(errors)
    return Scores(
        Score(
            "small", "split", seed, experiment, "nmte_percent", error, "percent", 0.1, Tally([word])
        )
        for seed, (error, word) in enumerate(zip(errors, words))
    )


def test_median_of_odd_and_even_numbers_of_seeds():
    assert spread([3.0, 1.0, 8.0], worst=True) == (3.0, 1.0, 8.0)
    assert spread([2.0, 1.0], worst=True) == (1.5, 1.0, 2.0)
    assert rows(3.0, 1.0, 8.0).spread("small", "split", "decay", "nmte_percent") == (3.0, 1.0, 8.0)


def test_a_failed_seed_counts_as_infinitely_wrong():
    for failed in (np.nan, np.inf):
        median, low, high = spread([3.0, failed, 8.0], worst=True)
        assert (median, low) == (8.0, 3.0) and np.isnan(high)


def test_a_median_seed_that_failed_leaves_no_number():
    median, low, high = spread([3.0, np.nan], worst=True)
    assert np.isnan(median) and low == 3.0 and np.isnan(high)
    assert all(np.isnan(spread([np.nan, np.inf], worst=True)))


def test_without_a_worst_side_failed_seeds_are_left_out_unless_they_are_half():
    assert spread([3.0, np.nan, 8.0], worst=False) == (5.5, 3.0, 8.0)
    assert all(np.isnan(spread([3.0, np.nan], worst=False)))


def test_outcomes_of_seeds_are_counted():
    scores = rows(1.0, np.nan, 2.0, outcomes=["ok", "diverged", "ok"])
    assert str(scores.outcome("small", "split", "decay")) == "ok 2, diverged 1"
    assert str(scores.outcome("small", "split", "forced")) == "not_run"


def test_the_drawn_seed_is_the_middle_one_and_failed_seeds_come_last():
    scores = rows(9.0, np.nan, 2.0)
    assert scores.median_seed("small", "split", [0, 1, 2]) == 0
    assert scores.median_seed("small", "split", [0, 2]) == 2


def test_scores_come_back_from_their_file_as_they_were(tmp_path, scores):
    hostile = [
        Score("NA", "1e5", None, "frc", "completed", np.nan, "1", np.nan, Tally()),
        Score("01", "null", 7, "frc", "error", 0.1 + 0.2, "percent", np.inf, Tally(["ok"] * 33)),
        Score("on", "a, b", 0, "frc", "e", 5e-324, "1", 0.0, Tally(["ok", "diverged", "ok"])),
    ]
    Scores([*hostile, *scores.rows]).write(tmp_path / "scores.csv")
    back = Scores.read(tmp_path / "scores.csv").rows
    assert list(map(repr, back)) == list(map(repr, [*hostile, *scores.rows]))


def test_scores_that_are_not_what_was_written_are_refused(tmp_path, scores):
    path = tmp_path / "scores.csv"
    scores.write(path)
    path.write_text(path.read_text().replace("ok", "diverged", 1))
    with pytest.raises(DataError, match="scores.csv: not what was written; delete it"):
        Scores.read(path)


def test_scores_are_those_of_the_artefacts(collection, scores):
    answer = collection.find("small", "split", "frc", 1)
    own = scores.of_experiment("small", "split", "frc")
    assert [row.metric for row in own if row.seed == 1] == list(answer["score"].values)
    assert scores.value("small", "split", 1, "frc", "completed") == 9.0
    assert own[0].outcome.total() == 9  # of all points
    assert not scores.of_experiment("small", "full_order", "frc")  # the truth has no error


@pytest.mark.parametrize("worst", [True, False])
def test_no_values_have_no_spread(worst):
    assert all(np.isnan(spread([], worst=worst)))


def test_every_run_has_its_work_balance_as_a_score(collection, scores):
    for run in ("train", "test", "forced", "frc"):
        known = np.nanmax(collection.find("small", "full_order", run)["balance"].values)
        (row,) = scores.of_experiment("small", "full_order", "balance", f"{run}_percent")
        assert row.value == 100.0 * known > 0.0 and row.unit == "percent"
    study = collection.find("small", "full_order", "trust")
    assert {"split", "modal_projection"} <= set(study["model"].values)
    for run, fit in product(("decay", "forced"), range(study.sizes["fit"])):
        mine = study.isel(fit=fit)
        seed = None if mine["model_seed"] < 0 else int(mine["model_seed"])
        whose = ("small", mine["model"].item(), seed)
        (row,) = (
            row
            for row in scores.of_experiment(*whose[:2], "balance", f"{run}_percent")
            if str(row.seed) == str(seed)  # as tables write it: 0, and not 0.0
        )
        value = float(mine[f"{run}_balance"])
        assert np.array_equal(row.value, 100.0 * value, equal_nan=True)
        broken = value > study.attrs["tolerance"]
        assert (row.outcome == Tally(["unbalanced"])) == broken
    metrics = {row.metric for row in scores.of_experiment("small", "split", "balance")}
    assert metrics == {"decay_percent", "forced_percent"}  # the scene has no other run
