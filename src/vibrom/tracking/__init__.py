"""Finished artefacts -> MLflow. Nothing outside this package imports mlflow.

The store is a view of the artefacts and is built from scratch each time, so that a run that is made
again replaces the old one and a run that no longer belongs to the configuration is gone; nothing
has to be looked up or deleted. One process writes it, because two that open a new sqlite store at
once crash. Values that are not finite are left out: the outcome, which is a tag, says why there is
none. Where MLFLOW_TRACKING_URI is set, the same runs are sent there too.
"""

from __future__ import annotations

import logging
import math
import os
import re
import shlex
import shutil
import socket
import tempfile
import uuid
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from vibrom.artefacts.extras import need

need("mlflow", "tracking", "workflow")
from vibrom.tracking import stored_model, views  # noqa: E402

EXPERIMENT = "vibrom"
NOTE = (
    "**vibrom**: which reduced-order model predicts a structure that bends far, how well, and what "
    "does that accuracy cost in time? One run is one model in one scene; errors are in percent, "
    "times in seconds. The whole answer is in `results/report.html`."
)
# What the store takes in one request, which holds both.
METRICS, PARAMS = 900, 100
# Points of a curve: the artefact has all of them, a chart needs no more.
POINTS = 250
OWNER = "vibrom.store"  # the tag of runs on a server: which store they are those of


class TrackingError(Exception):
    """A store or a server that cannot be used; the message says what to do."""


@dataclass(frozen=True)
class Data:
    """What a run was made from."""

    name: str
    digest: str
    source: str  # where it lies
    context: str = "training"


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
    note: str = ""  # what the run is, as Markdown
    began: float = 0.0  # s since 1970; 0: now
    seconds: float = 0.0  # of work
    data: tuple[Data, ...] = ()
    model: stored_model.Parts | None = None  # of a fitted model


def record(runs: Iterable[TrackedRun], *, store: str | Path, artifacts: str | Path) -> None:
    """A new store with these runs; and the same on the server of MLFLOW_TRACKING_URI."""
    runs, server = list(runs), os.environ.get("MLFLOW_TRACKING_URI")
    client_of = _mlflow()
    store, artifacts = Path(store).absolute(), Path(artifacts).absolute()
    shutil.rmtree(artifacts, ignore_errors=True)
    artifacts.mkdir(parents=True)
    # Elsewhere until it is complete: a store is there as a whole or not at all. And where the path
    # has no character that means something in an address, as a project's may.
    with tempfile.TemporaryDirectory(prefix="vibrom_mlflow_") as folder:
        made = Path(folder) / "mlflow.db"
        with _unsafe_until_whole():
            client = client_of(tracking_uri=f"sqlite:///{made}")
            experiment = client.create_experiment(EXPERIMENT, artifact_location=artifacts.as_uri())
            _fill(client, experiment, runs)
        partial = store.with_name(f".{store.name}.{uuid.uuid4().hex}.partial")
        try:
            shutil.copyfile(made, partial)
            os.replace(partial, store)
        finally:
            partial.unlink(missing_ok=True)
    if server:
        _send(client_of, server, runs, f"{socket.gethostname()}:{store}")


def command(store: str | Path) -> str:
    """Which shows the runs of a store."""
    folder = os.path.relpath(Path(store).parent)
    folder = str(Path(store).parent) if folder.startswith("..") else folder
    return "make ui" if folder == "results" else f"make ui RESULTS={shlex.quote(folder)}"


def thinned(steps: Iterable[int], values: Iterable[float]) -> list[tuple[int, float]]:
    """At most `POINTS` evenly spread points of a curve, its last one among them."""
    curve = list(zip(steps, values, strict=True))
    stride = -(-len(curve) // POINTS) or 1
    return curve[::-1][::stride][::-1]


@contextmanager
def _unsafe_until_whole() -> Iterator[None]:
    """Nothing waits for the disk while a store is filled that is copied when it is whole: MLflow
    commits some twenty times a run.
    """
    from sqlalchemy import event
    from sqlalchemy.engine import Engine

    def connected(connection, _):
        connection.execute("pragma synchronous = off")
        connection.execute("pragma journal_mode = memory")

    event.listen(Engine, "connect", connected)
    try:
        yield
    finally:
        event.remove(Engine, "connect", connected)


def _mlflow():
    """The class of its clients, silent."""
    os.environ.setdefault("MLFLOW_DISABLE_TELEMETRY", "true")
    os.environ.setdefault("DO_NOT_TRACK", "true")
    os.environ.setdefault("MLFLOW_HTTP_REQUEST_MAX_RETRIES", "2")
    from mlflow import MlflowClient

    # Making the tables of a new store is not news.
    for name in ("mlflow", "mlflow.store.db.utils", "alembic"):
        logging.getLogger(name).setLevel(logging.WARNING)
    return MlflowClient


def _send(client_of, address: str, runs: list[TrackedRun], owner: str) -> None:
    """The runs to a server, in place of those that this store sent before."""
    from mlflow.exceptions import MlflowException

    try:
        client = client_of(tracking_uri=address)
        known = client.get_experiment_by_name(EXPERIMENT)
        experiment = known.experiment_id if known else client.create_experiment(EXPERIMENT)
        wanted = f"tags.`{OWNER}` = '{owner}'"
        for old in client.search_runs([experiment], wanted, max_results=5000):
            client.delete_run(old.info.run_id)
        _fill(client, experiment, runs, {OWNER: owner})
    except (MlflowException, OSError) as error:
        reason = str(error).split("(Caused by")[0].strip().splitlines()[0][:200]
        raise TrackingError(
            f"MLFLOW_TRACKING_URI = {address}: the runs could not be sent there ({reason}); start "
            "that server, or unset the variable"
        ) from error
    print(f"{len(runs)} runs sent to {address}")


def _fill(client, experiment: str, runs: list[TrackedRun], tags: dict[str, str] | None = None):
    """All runs, and the views that compare them."""
    for run in runs:
        _log(client, experiment, run, tags or {})
    client.set_experiment_tag(experiment, "mlflow.note.content", NOTE)
    for key, value in views.tags(runs).items():
        client.set_experiment_tag(experiment, key, value)


def _log(client, experiment: str, run: TrackedRun, more: dict[str, str]) -> None:
    from mlflow.entities import Metric, Param

    source = {"mlflow.source.name": "Snakefile", "mlflow.source.type": "PROJECT"}
    tags = source | run.tags | more | ({"mlflow.note.content": run.note} if run.note else {})
    start = round(1000 * run.began) or None
    made = client.create_run(experiment, start_time=start, run_name=run.name, tags=tags)
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
    while points or params:
        client.log_batch(identity, points[:METRICS], params[:PARAMS], synchronous=True)
        del points[:METRICS], params[:PARAMS]
    for folder, files in run.files.items():
        for file in files:
            client.log_artifact(identity, file, folder)
    _log_data(client, identity, run.data)
    if run.model is not None:
        _log_model(client, experiment, identity, run)
    client.set_terminated(identity, end_time=now + round(1000 * run.seconds))


def _log_data(client, identity: str, data: tuple[Data, ...]) -> None:
    """The datasets of a run, each with its digest."""
    from mlflow.entities import Dataset, DatasetInput, InputTag

    inputs = [
        DatasetInput(
            Dataset(one.name, one.digest, "local", f'{{"uri": "{one.source}"}}'),
            [InputTag("mlflow.data.context", one.context)],
        )
        for one in data
    ]
    if inputs:
        client.log_inputs(identity, inputs)


def _log_model(client, experiment: str, identity: str, run: TrackedRun) -> None:
    """The fitted model, such that `mlflow.pyfunc.load_model` gives what predicts its decay."""
    from mlflow.entities import LoggedModelOutput

    named = re.sub(r"[^\w-]", "_", run.name)  # names of models have no dots, those of scenes may
    made = client.create_logged_model(experiment, named, source_run_id=identity)
    with tempfile.TemporaryDirectory() as folder:
        home = Path(folder) / "model"
        stored_model.save(run.model, home)
        client.log_model_artifacts(made.model_id, str(home))
    client.finalize_logged_model(made.model_id, "READY")
    client.log_outputs(identity, [LoggedModelOutput(made.model_id, 0)])
    line = stored_model.LOAD.format(identity=made.model_id)
    note = f"{run.note}\n\n{line}".strip()
    client.set_tag(identity, "mlflow.note.content", note)
