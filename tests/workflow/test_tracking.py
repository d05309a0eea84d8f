"""The MLflow store is a view of the artefacts: built again, it holds the same runs once."""

import json
import math
import os
import signal
import socket
import sqlite3
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from project_copy import until

from vibrom import tracking
from vibrom.tracking import TrackedRun, record, thinned
from vibrom.tracking import __main__ as serve
from vibrom.tracking.stored_model import Parts


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
                note="This is one model.",
                began=1e9,
                seconds=2.5,
                data=(tracking.Data("folding train", "0123abc", "results/train.nc"),),
            ),
            TrackedRun("summary", files={"tables": [str(table)]}),
            TrackedRun("1.5-long ssmlearn unseeded", model=Parts(str(table), str(table), {}, 200)),
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
        ("1.5-long ssmlearn unseeded", "FINISHED", "active"),
        ("folding split seed_0", "FINISHED", "active"),
        ("summary", "FINISHED", "active"),
    ]
    assert rows(store, "select value from latest_metrics where key = 'decay/nmte_percent'") == [
        (2.5,)
    ]


def test_any_scene_may_have_a_model(store):
    """MLflow takes no dots in the name of one."""
    assert rows(store, "select name, status from logged_models") == [
        ("1_5-long_ssmlearn_unseeded", 2)
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


def test_links_open_views_that_the_store_has(store):
    ((identity,),) = rows(store, "select experiment_id from experiments where name = 'vibrom'")
    found = serve.links(store / "mlflow.db", "http://here:1")
    kept = dict(rows(store, "select key, value from experiment_tags"))
    for address in found.values():
        start, key = address.split("&viewStateShareKey=")
        assert start == f"http://here:1/#/experiments/{identity}/runs?workflowType=machine_learning"
        view = json.loads(kept[f"mlflow.sharedViewState.{key.split('&')[0]}"])
        state = json.loads(view["state"])
        assert {"params.`scene`", "params.`method`", "metrics.`decay/nmte_percent`"} <= set(
            state["selectedColumns"]
        )
        scenes = {"mode": "param", "groupByData": "scene"}
        models = {"mode": "tag", "groupByData": "model"}  # the mean over seeds of each
        wanted = scenes if key == "table" else models
        assert state["groupBy"] == {"aggregateFunction": "average", "groupByKeys": [wanted]}
        # A column that has no place here stands behind all that have one, and is as wide as before.
        assert set(state["selectedColumns"]) < set(state["columnOrder"])
        assert state["columnOrder"][0] == "attributes.`Run Name`"
        assert set(state["columnOrder"]) == set(state["columnWidths"])
    assert [address.endswith("compareRunsMode=CHART") for address in found.values()].count(
        True
    ) == 1


def test_a_run_has_source_duration_note_and_data(store):
    mine = "join runs using (run_uuid) where name like 'folding%'"
    tags = dict(rows(store, f"select key, value from tags {mine}"))
    assert tags["mlflow.source.name"] == "Snakefile" and "one model" in tags["mlflow.note.content"]
    assert rows(store, "select end_time - start_time from runs where name like 'folding%'") == [
        (2500,)
    ]
    assert rows(store, "select name, digest from datasets") == [("folding train", "0123abc")]


def test_any_path_holds_a_store_that_may_be_moved_and_nothing_is_left_outside(tmp_path):
    from mlflow import MlflowClient

    name = "a?b#c%20d e"
    before, after, table = tmp_path / name, tmp_path / "after", tmp_path / "decay.csv"
    before.mkdir()
    table.write_text("case\n")
    runs = [TrackedRun("summary", files={"tables": [str(table)]})]
    record(runs, store=before / "mlflow.db", artifacts=before / "mlflow_artifacts")
    assert serve.experiment(before / "mlflow.db") == "1"
    assert sorted(path.name for path in before.iterdir()) == ["mlflow.db", "mlflow_artifacts"]
    assert sorted(path.name for path in tmp_path.iterdir()) == [name, table.name]
    before.rename(after)
    serve.relocate(after / "mlflow.db")
    client = MlflowClient(f"sqlite:///{after / 'mlflow.db'}")
    (run,) = client.search_runs(["1"])
    path = client.download_artifacts(run.info.run_id, "tables/decay.csv")
    assert Path(path).read_text() == "case\n"
    assert after.as_uri() in run.info.artifact_uri


def complaint(capsys, *words) -> str:
    """The one line that the command ends with."""
    with pytest.raises(SystemExit) as ended:
        serve.main(list(words))
    line = str(ended.value)
    assert line.startswith("vibrom: ") and "\n" not in line
    return line


def test_what_cannot_be_served_is_one_line(store, tmp_path, capsys):
    good, bad = str(store / "mlflow.db"), tmp_path / "bad.db"
    assert "no such store" in complaint(capsys, str(tmp_path / "none.db"), "5000")
    bad.write_text("hello, this is no database, and it is long enough to look like one" * 20)
    assert "not a store of MLflow" in complaint(capsys, str(bad), "5000")
    with sqlite3.connect(tmp_path / "other.db") as other:
        other.execute("create table mine (a int)")
    assert "not a store of MLflow" in complaint(capsys, str(tmp_path / "other.db"), "5000")
    with socket.socket() as busy:
        busy.bind(("127.0.0.1", 0))
        busy.listen()
        port = str(busy.getsockname()[1])
        assert f"port {port}: cannot be used" in complaint(capsys, good, port)
    assert "give a number" in complaint(capsys, good, "http")
    assert capsys.readouterr().out == ""  # no address of a stranger's server


def test_what_one_user_looks_at_needs_one_server(store, tmp_path, monkeypatch, capsys):
    """Without being told, MLflow starts four, and eight processes for work that nobody asks."""
    started = []
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(os, "execv", lambda program, words: started.append(words))
    monkeypatch.setattr(os, "environ", {"MLFLOW_TRACKING_URI": "http://else.where"})
    serve.serve(str(store / "mlflow.db"), 0)
    assert started[0][-2:] == ["--workers", "1"] and "sqlite:///mlflow.db" in started[0]
    assert os.environ["MLFLOW_SERVER_ENABLE_JOB_EXECUTION"] == "false"
    assert "MLFLOW_TRACKING_URI" not in os.environ
    assert "http://127.0.0.1:0/#/experiments/1" in capsys.readouterr().out


# What `mlflow server` starts after 8 s, without the processes for work that nobody asks of it.
SERVER = ["uvicorn", "mlflow.server.fastapi_app:app", "--host", "127.0.0.1", "--port"]
KNOWS = {
    "MLFLOW_SERVER_ENABLE_JOB_EXECUTION": "false",
    "_MLFLOW_SERVER_FILE_STORE": "sqlite:///server.db",
    "_MLFLOW_SERVER_ARTIFACT_ROOT": "mlflow-artifacts:/",
    "_MLFLOW_SERVER_ARTIFACT_DESTINATION": "./mlartifacts",
    "_MLFLOW_SERVER_SERVE_ARTIFACTS": "true",
}


def listens(port: int) -> bool:
    try:
        socket.create_connection(("127.0.0.1", port), timeout=1).close()
    except OSError:
        return False
    return True


@pytest.fixture(scope="module")
def server(tmp_path_factory):
    """A tracking server on the loopback."""
    folder = tmp_path_factory.mktemp("server")
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    command = [sys.executable, "-m", *SERVER, str(port)]
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "env": os.environ | KNOWS}
    process = subprocess.Popen(command, cwd=folder, start_new_session=True, **quiet)
    try:
        until(lambda: process.poll() is not None or listens(port))
        yield f"http://127.0.0.1:{port}"
    finally:
        os.killpg(process.pid, signal.SIGTERM)
        process.wait()


def test_the_same_runs_go_to_a_server_and_replace_what_was_sent(server, tmp_path, monkeypatch):
    from mlflow import MlflowClient

    monkeypatch.setenv("MLFLOW_TRACKING_URI", server)
    table = tmp_path / "decay.csv"
    table.write_text("case\n")
    for value in (1.5, 2.5):
        runs = [TrackedRun("small split seed_0", {"scene": "small"}, {"decay/nmte_percent": value})]
        runs.append(TrackedRun("summary", files={"tables": [str(table)]}))
        record(runs, store=tmp_path / "mlflow.db", artifacts=tmp_path / "artifacts")
    client = MlflowClient(server)
    experiment = client.get_experiment_by_name("vibrom")
    found = {run.info.run_name: run for run in client.search_runs([experiment.experiment_id])}
    assert set(found) == {"small split seed_0", "summary"}
    assert found["small split seed_0"].data.metrics == {"decay/nmte_percent": 2.5}
    assert "mlflow.sharedViewState.table" in experiment.tags
    names = [file.path for file in client.list_artifacts(found["summary"].info.run_id, "tables")]
    assert names == ["tables/decay.csv"]


def test_a_server_that_is_not_there_is_one_line(tmp_path, monkeypatch):
    monkeypatch.setenv("MLFLOW_TRACKING_URI", "http://127.0.0.1:9")
    monkeypatch.setenv("MLFLOW_HTTP_REQUEST_MAX_RETRIES", "0")
    with pytest.raises(tracking.TrackingError, match="could not be sent there") as error:
        record([TrackedRun("one")], store=tmp_path / "mlflow.db", artifacts=tmp_path / "artifacts")
    assert "\n" not in str(error.value) and (tmp_path / "mlflow.db").exists()


@pytest.mark.parametrize("count", [0, 1, 249, 250, 251, 5000])
def test_thinning_keeps_the_end(count):
    points = thinned(range(count), range(count))
    assert len(points) <= tracking.POINTS and (not count or points[-1] == (count - 1, count - 1))
