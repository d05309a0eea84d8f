"""The fitted models with their losses and scores, tables and figures -> the MLflow store."""

import json
import os
from pathlib import Path

import numpy as np
import xarray as xr

from vibrom import tracking
from vibrom.report.collection import FULL_ORDER, Collection, outcome
from vibrom.report.scores import Score, Scores
from vibrom.tracking import TrackedRun


def run(
    *,
    artefacts: list[str],
    scores: str,
    tables: list[str],
    figures: list[str],
    store: str,
    artifacts: str,
    provenance: dict[str, str],
) -> None:
    """A run for each fitted model, one for each full-order model, and a summary with the files."""
    collection = Collection.at(artefacts)
    scored = Scores.of(collection)
    runs = [_model(collection, scored, *key[:3]) for key in collection.loaders if key.name == "rom"]
    for scene in collection.scenes:
        mine = [row for row in scored.rows if row[:2] == (scene, FULL_ORDER)]
        if mine:
            params = {"scene": scene, "method": FULL_ORDER}
            name = f"{scene} {FULL_ORDER}"
            runs.append(TrackedRun(name, params, _metrics(mine), tags=_outcomes(mine)))
    files = {"tables": tables, "figures": figures, "": [scores]}
    runs.append(TrackedRun("summary", tags={"role": "summary", **provenance}, files=files))
    tracking.record(runs, store=store, artifacts=artifacts)
    print(f"{len(runs)} runs in {store}; `make ui` shows them")


def _model(
    collection: Collection, scores: Scores, scene: str, method: str, seed: int | None
) -> TrackedRun:
    """One fitted model: settings, scores, outcomes, loss curves, and where its artefacts are."""
    rom, losses = (collection.find(scene, method, name, seed) for name in ("rom", "losses"))
    mine = [row for row in scores.rows if row[:3] == (scene, method, seed)]
    params = {
        "scene": scene,
        "method": method,
        "seed": "unseeded" if seed is None else seed,
        **_flat(json.loads(rom.attrs.get("settings", "{}"))),
    }
    seconds = {
        f"fit/{name}": float(rom[name])
        for name in ("data_seconds", "mapping_seconds", "dynamics_seconds")
        if name in rom
    }
    made_by = {
        name: str(rom.attrs[name]) for name in ("source_digest", "versions") if name in rom.attrs
    }
    folder = os.path.relpath(Path(rom.encoding["source"]).parent)
    tags = {"artefacts": folder, "outcome.fit": outcome(rom).value, **made_by, **_outcomes(mine)}
    name = f"{scene} {method} {'unseeded' if seed is None else f'seed_{seed}'}"
    return TrackedRun(name, params, seconds | _metrics(mine), _curves(losses), tags)


def _metrics(rows: list[Score]) -> dict[str, float]:
    return {f"{row.experiment}/{row.metric}": row.value for row in rows}


def _outcomes(rows: list[Score]) -> dict[str, str]:
    return {f"outcome.{row.experiment}": str(row.outcome) for row in rows}


def _curves(losses: xr.Dataset | None) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Loss curves by name: losses/train_total, ..."""
    if losses is None:
        return {}
    epoch = losses["epoch"].values.astype(int)
    return {
        f"losses/{name}": (epoch, values.values)
        for name, values in losses.data_vars.items()
        if values.dims == ("epoch",)
    }


def _flat(settings: dict, prefix: str = "") -> dict[str, object]:
    """Nested settings with dotted names."""
    flat: dict[str, object] = {}
    for name, value in settings.items():
        flat |= (
            _flat(value, f"{prefix}{name}.")
            if isinstance(value, dict)
            else {f"{prefix}{name}": value}
        )
    return flat
