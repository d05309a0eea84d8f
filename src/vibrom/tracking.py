"""Finished artefacts -> MLflow. The only importer of mlflow.

The store is a view of the artefacts and is built from scratch each time, so that a run that is made
again replaces the old one and a run that no longer belongs to the configuration is gone; nothing
has to be looked up or deleted. One process writes it, because two that open a new sqlite store at
once crash. Values that are not finite are left out: the outcome, which is a tag, says why there is
none.
"""

import logging
import math
import os
import shutil
import sqlite3
import sys
import uuid
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

EXPERIMENT = "vibrom"
# What the store takes in one request.
METRICS, PARAMS = 1000, 100
# Points of a curve: the artefact has all of them, a chart needs no more.
POINTS = 250


@dataclass(frozen=True)
class TrackedRun:
    """One model in one scene, or the summary of all."""

    name: str
    params: dict[str, Any] = field(default_factory=dict)
    metrics: dict[str, float] = field(default_factory=dict)  # decay/nmte_percent -> value
    curves: dict[str, tuple[Iterable[int], Iterable[float]]] = field(
        default_factory=dict
    )  # name -> steps, values
    tags: dict[str, str] = field(default_factory=dict)
    files: dict[str, list[str]] = field(default_factory=dict)  # folder in the store -> files


def record(runs: Iterable[TrackedRun], *, store: str | Path, artifacts: str | Path) -> None:
    """A new store with these runs."""
    os.environ.setdefault("MLFLOW_DISABLE_TELEMETRY", "true")
    os.environ.setdefault("DO_NOT_TRACK", "true")
    from mlflow import MlflowClient

    # Making the tables of a new store is not news.
    for name in ("mlflow", "mlflow.store.db.utils", "alembic"):
        logging.getLogger(name).setLevel(logging.WARNING)

    store, artifacts = Path(store).absolute(), Path(artifacts).absolute()
    shutil.rmtree(artifacts, ignore_errors=True)
    artifacts.mkdir(parents=True)
    # Under a new name until it is complete: a store is there as a whole or not at all.
    partial = store.with_name(f".{store.name}.{uuid.uuid4().hex}.partial")
    try:
        client = MlflowClient(tracking_uri=f"sqlite:///{partial}")
        experiment = client.create_experiment(EXPERIMENT, artifact_location=artifacts.as_uri())
        for run in runs:
            _log(client, experiment, run)
        os.replace(partial, store)
    finally:
        for path in store.parent.glob(f"{partial.name}*"):
            path.unlink()


def thinned(steps: Iterable[int], values: Iterable[float]) -> list[tuple[int, float]]:
    """At most `POINTS` evenly spread points of a curve, its last one among them."""
    curve = list(zip(steps, values, strict=True))
    stride = -(-len(curve) // POINTS) or 1
    return curve[::-1][::stride][::-1]


def _log(client, experiment: str, run: TrackedRun) -> None:
    from mlflow.entities import Metric, Param

    made = client.create_run(experiment, run_name=run.name, tags=run.tags)
    identity, now = made.info.run_id, made.info.start_time
    points = [
        Metric(name, float(value), now, 0)
        for name, value in run.metrics.items()
        if math.isfinite(value)
    ]
    for name, (steps, values) in run.curves.items():
        points += [
            Metric(name, float(value), now, int(step))
            for step, value in thinned(steps, values)
            if math.isfinite(value)
        ]
    params = [Param(name, str(value)[:6000]) for name, value in run.params.items()]
    for start in range(0, len(points), METRICS):
        client.log_batch(identity, metrics=points[start : start + METRICS], synchronous=True)
    for start in range(0, len(params), PARAMS):
        client.log_batch(identity, params=params[start : start + PARAMS], synchronous=True)
    for folder, files in run.files.items():
        for file in files:
            client.log_artifact(identity, file, folder)
    client.set_terminated(identity)


def link(store: str | Path, address: str) -> str:
    """Where the comparison table is; a fresh browser would open MLflow's other mode."""
    with sqlite3.connect(f"file:{Path(store).absolute()}?mode=ro", uri=True) as database:
        (identity,) = database.execute(
            "select experiment_id from experiments where name = ?", (EXPERIMENT,)
        ).fetchone()
    return f"{address}/#/experiments/{identity}/runs?workflowType=machine_learning"


def serve(store: str, port: int = 5000) -> None:
    """Print the link and become MLflow's server."""
    if not Path(store).exists():
        sys.exit(f"vibrom: {store}: no such store; run the main job first (make)")
    print(
        f"Comparison table: {link(store, f'http://127.0.0.1:{port}')}\nStop with Ctrl-C.",
        flush=True,
    )
    os.environ.setdefault("MLFLOW_DISABLE_TELEMETRY", "true")
    command = [
        sys.executable,
        "-m",
        "mlflow",
        "ui",
        "--backend-store-uri",
        f"sqlite:///{Path(store).absolute()}",
        "--port",
        str(port),
    ]
    os.execv(sys.executable, command)


if __name__ == "__main__":
    serve(
        sys.argv[1] if len(sys.argv) > 1 else "results/mlflow.db",
        int(sys.argv[2]) if len(sys.argv) > 2 else 5000,
    )
