"""The MLflow store is a view of the artefacts: built again, it holds the same runs once."""

import math
import sqlite3

import numpy as np
import pytest

from vibrom import tracking
from vibrom.tracking import TrackedRun, record, thinned


@pytest.fixture(scope="module")
def store(tmp_path_factory):
    """A store that was recorded twice, the second time with one run less and another value."""
    folder = tmp_path_factory.mktemp("store")
    table = folder / "decay.csv"
    table.write_text("case,method\n")
    curve = (range(1, 1001), np.linspace(1.0, 0.0, 1000))
    broken = (range(1, 4), [1.0, math.nan, math.inf])
    for value in (1.5, 2.5):
        runs = [
            TrackedRun(
                "folding split seed_0",
                {
                    "scene": "folding",
                    "hidden": [64, 32],
                    **{f"p{index}": index for index in range(150)},
                },
                {"decay/nmte_percent": value, "forced/nmte_percent": math.nan},
                {"losses/train_total": curve, "losses/test_total": broken},
                {"outcome.forced": "diverged", "artefacts": "results/folding/split/seed_0"},
            ),
            TrackedRun("summary", files={"tables": [str(table)]}),
        ]
        if value == 1.5:
            runs.append(TrackedRun("small split seed_0"))
        record(runs, store=folder / "mlflow.db", artifacts=folder / "artifacts")
    return folder


def rows(folder, query):
    with sqlite3.connect(folder / "mlflow.db") as database:
        return database.execute(query).fetchall()


def test_recording_again_replaces(store):
    assert sorted(rows(store, "select name, status, lifecycle_stage from runs")) == [
        ("folding split seed_0", "FINISHED", "active"),
        ("summary", "FINISHED", "active"),
    ]
    assert rows(store, "select value from latest_metrics where key = 'decay/nmte_percent'") == [
        (2.5,)
    ]


def test_values_that_are_not_finite_are_left_out(store):
    assert rows(store, "select count(*) from metrics where key = 'forced/nmte_percent'") == [(0,)]
    assert rows(store, "select step, value from metrics where key = 'losses/test_total'") == [
        (1, 1.0)
    ]
    assert rows(store, "select value from tags where key = 'outcome.forced'") == [("diverged",)]


def test_curves_params_and_files_arrive(store):
    points = rows(
        store, "select step, value from metrics where key = 'losses/train_total' order by step"
    )
    assert 100 < len(points) <= tracking.POINTS and points[-1] == (1000, 0.0)
    assert rows(store, "select count(*) from params") == [(152,)]
    assert len(list((store / "artifacts").rglob("tables/decay.csv"))) == 1


def test_link_lands_on_the_comparison_table(store):
    ((identity,),) = rows(store, "select experiment_id from experiments where name = 'vibrom'")
    assert (
        tracking.link(store / "mlflow.db", "http://here:1")
        == f"http://here:1/#/experiments/{identity}/runs?workflowType=machine_learning"
    )


@pytest.mark.parametrize("count", [0, 1, 249, 250, 251, 5000])
def test_thinning_keeps_the_end(count):
    points = thinned(range(count), range(count))
    assert len(points) <= tracking.POINTS and (not count or points[-1] == (count - 1, count - 1))
