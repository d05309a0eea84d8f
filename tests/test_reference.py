"""A run's scores beside the reference: what is told, and what is within its tolerance."""

import subprocess
import sys
from pathlib import Path

import pandas as pd
import pytest

from vibrom.artefacts.files import DataError
from vibrom.report import reference

OWN = Path(__file__).parents[1] / "config/reference_scores.csv"
ROWS = pd.DataFrame(
    [
        ("folding", "ssmlearn", "unseeded", "decay", "nmte_percent", 10.0, "percent", 1.0, "ok"),
        ("folding", "split", "0", "decay", "nmte_percent", 1.0, "percent", 1.0, "ok"),
        ("folding", "split", "0", "frc", "completed", 33.0, "1", 1.0, "ok 33"),
        (
            "folding",
            "ssmlearn",
            "unseeded",
            "forced",
            "nmte_percent",
            None,
            "percent",
            1.0,
            "diverged",
        ),
        ("folding", "ssmlearn", "unseeded", "run_times", "decay_s", 0.01, "s", 1.0, "ok"),
        ("folding", "full_order", "unseeded", "branches", "fold", 400.0, "rad/s", 1.0, "ok"),
    ],
    columns=[*reference.KEY[:5], "value", "unit", "seconds", "outcome"],
)


@pytest.fixture
def told(tmp_path):
    """What differs after some cells were changed."""
    known = tmp_path / "reference.csv"
    ROWS.to_csv(known, index=False)

    def run(*changes):
        table = ROWS.copy()
        for row, column, value in changes:
            table.loc[row, column] = value
        table.to_csv(tmp_path / "scores.csv", index=False)
        return list(
            map(str, reference.differences(*map(reference.read, (tmp_path / "scores.csv", known))))
        )

    return run


def test_equal_scores_differ_in_nothing_and_wall_times_are_not_compared(told):
    assert told((4, "value", 5.0), (0, "seconds", 9.0)) == []


@pytest.mark.parametrize(
    "row, within, beyond", [(0, 10.19, 10.21), (1, 1.51, 1.53), (2, 20, 15), (5, 400.3, 400.5)]
)
def test_a_tolerance_is_that_of_the_unit_and_of_what_drew_random_numbers(told, row, within, beyond):
    assert told((row, "value", within)) == []
    (words,) = told((row, "value", beyond))
    assert str(beyond) in words and f"the reference {ROWS['value'][row]:g}" in words


def test_what_is_missing_new_or_ends_otherwise_is_said(told):
    (gone, new) = told((0, "experiment", "sweeps"))
    assert gone == "folding, ssmlearn, unseeded: decay nmte_percent: is missing"
    assert new == "folding, ssmlearn, unseeded: sweeps nmte_percent: is new"
    (words,) = told((0, "outcome", "left_range"))
    assert words.endswith("ended left_range, the reference ok")
    (words,) = told((3, "value", 4.0))
    assert "4, the reference nan percent" in words
    (words,) = told((1, "value", None))
    assert "nan, the reference 1 percent" in words


def test_a_file_without_scores_is_one_line(tmp_path):
    (tmp_path / "scores.csv").write_text("a,b\n1,2\n")
    with pytest.raises(DataError, match="scores.csv: is no table of scores"):
        reference.read(tmp_path / "scores.csv")
    with pytest.raises(DataError, match="run `snakemake scores`"):
        reference.read(tmp_path / "none.csv")


def test_the_command_ends_with_what_differs(tmp_path):
    """The project's own reference against itself, unchanged and with one score changed."""
    table = pd.read_csv(OWN, keep_default_na=False, dtype=str)
    assert len(table) > 1000 and not table.duplicated(reference.KEY).any()
    reference.keep(OWN, tmp_path / "kept.csv")
    assert reference.compared(OWN, tmp_path / "kept.csv")[1]
    assert len(pd.read_csv(tmp_path / "kept.csv")) == len(table)
    table.loc[0, "value"] = "-1e9"
    table.loc[1, "metric"], gone = "another", 2
    table = table.drop(index=gone)
    table.to_csv(tmp_path / "scores.csv", index=False)
    command = [sys.executable, "-m", "vibrom", "compare", str(tmp_path / "scores.csv")]
    answer = subprocess.run([*command, "--reference", OWN], capture_output=True, text=True)
    assert answer.returncode == 1 and "-1e+09, the reference" in answer.stdout
    head, *lines = answer.stdout.splitlines()
    assert head.startswith(f"{len(table) - 2} of {len(table) + 1} scores of")
    assert "; 1 differ, 2 are missing, 1 are new, of those of" in head
    assert len(lines) == 4 and [line.endswith("is new") for line in lines] == [False] * 3 + [True]
