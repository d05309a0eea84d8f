"""`python -m vibrom.tracking STORE PORT`: prints the links and becomes MLflow's server, which only
this machine can reach.
"""

from __future__ import annotations

import os
import socket
import sqlite3
import sys
from pathlib import Path
from urllib.parse import quote

from vibrom.tracking import EXPERIMENT, TrackingError, views

HOST = "127.0.0.1"


def connected(store: Path, mode: str = "ro") -> sqlite3.Connection:
    """The store as a database, whatever characters its path has."""
    return sqlite3.connect(f"file:{quote(str(store.absolute()))}?mode={mode}", uri=True)


def experiment(store: str | Path) -> str:
    """The number of the experiment of the runs."""
    store = Path(store)
    if not store.is_file():
        raise TrackingError(f"{store}: no such store; run the main job first (make)")
    try:
        with connected(store) as database:
            found = database.execute(
                "select experiment_id from experiments where name = ?", (EXPERIMENT,)
            ).fetchone()
    except sqlite3.Error as error:
        cure = "delete it and run the main job again (make)"
        raise TrackingError(f"{store}: not a store of MLflow ({error}); {cure}") from error
    if found is None:
        raise TrackingError(f"{store}: has no experiment {EXPERIMENT}; run the main job (make)")
    return str(found[0])


def links(store: str | Path, host: str) -> dict[str, str]:
    """What each view shows, and its address."""
    number = experiment(store)
    words = {
        "table": "Runs by scene",
        "methods": "Methods, mean over seeds",
        "charts": "Charts, mean over seeds",
    }
    return {name: views.address(host, number, key) for key, name in words.items()}


def relocate(store: str | Path) -> None:
    """Addresses of artefacts, which are whole, follow a project that was moved."""
    store = Path(store)
    with connected(store, "rw") as database:
        (old,) = database.execute(
            "select artifact_location from experiments where name = ?", (EXPERIMENT,)
        ).fetchone()
        new = (store.absolute().parent / Path(old).name).as_uri()
        if old != new:
            for table, column in (
                ("experiments", "artifact_location"),
                ("runs", "artifact_uri"),
                ("logged_models", "artifact_location"),
            ):
                database.execute(
                    f"update {table} set {column} = ? || substr({column}, ?) where {column} like ?",
                    (new, len(old) + 1, f"{old.replace('%', '_')}%"),
                )


def check_free(port: int) -> None:
    """Nobody listens there."""
    with socket.socket() as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((HOST, port))
        except (OSError, OverflowError) as error:
            cure = "choose another one, as make ui PORT=5050"
            raise TrackingError(f"port {port}: cannot be used ({error}); {cure}") from error


def serve(store: str, port: int) -> None:
    """Print the links and become MLflow's server."""
    found = links(store, f"http://{HOST}:{port}")
    check_free(port)
    relocate(store)
    for name, address in found.items():
        print(f"{name + ':':<26}{address}")
    print("Stop with Ctrl-C.", flush=True)
    os.environ.setdefault("MLFLOW_DISABLE_TELEMETRY", "true")
    # Nor eight more processes, which judge answers of language models.
    os.environ.setdefault("MLFLOW_SERVER_ENABLE_JOB_EXECUTION", "false")
    os.environ.pop("MLFLOW_TRACKING_URI", None)
    # From its folder: an address of a database cannot hold every path.
    place = Path(store).absolute()
    os.chdir(place.parent)
    command = [sys.executable, "-m", "mlflow", "ui", "--backend-store-uri"]
    command += [f"sqlite:///{place.name}", "--host", HOST, "--port", str(port), "--workers", "1"]
    os.execv(sys.executable, command)


def main(words: list[str]) -> None:
    """STORE and PORT, or what is usual."""
    store, port, *_ = [*words, *("results/mlflow.db", "5000")[len(words) :]]
    try:
        if not port.isdigit():
            raise TrackingError(f"port {port!r}: give a number, as make ui PORT=5050")
        serve(store, int(port))
    except (TrackingError, PermissionError) as error:
        sys.exit(f"vibrom: {error}")


if __name__ == "__main__":
    main(sys.argv[1:])
