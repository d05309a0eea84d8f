"""scores.csv, the fitted models with their losses, tables and figures -> the MLflow store."""

import json
from pathlib import Path

import pandas as pd
import xarray as xr

from vibrom import tracking
from vibrom.artefacts.data import UNSEEDED, open_dataset
from vibrom.tracking import TrackedRun

NAMING = ["scene", "method", "seed"]


def run(
    *,
    scores: str,
    fitted: list[str],
    tables: list[str],
    figures: list[str],
    store: str,
    artifacts: str,
    provenance: dict[str, str],
) -> None:
    table = pd.read_csv(scores, keep_default_na=True)
    rows = {
        key: group
        for key, group in table.assign(seed=[_seed(seed) for seed in table["seed"]]).groupby(
            NAMING, sort=False
        )
    }
    models = {
        (*Path(path).parts[-4:-2], Path(path).parts[-2]): path
        for path in fitted
        if Path(path).stem == "rom"
    }
    runs = [
        _model(key, path, rows.get((*key[:2], key[2].removeprefix("seed_"))))
        for key, path in models.items()
    ]
    runs += [_reference(key, group) for key, group in rows.items() if key[1] == "full_order"]
    runs.append(
        TrackedRun(
            "summary",
            tags={"role": "summary", **provenance},
            files={"tables": tables, "figures": figures, "": [scores]},
        )
    )
    tracking.record(runs, store=store, artifacts=artifacts)
    print(f"{len(runs)} runs in {store}; `make ui` shows them")


def _seed(value) -> str:
    """A seed of scores.csv as the last part of a folder's name: 0, 1, ..., or unseeded."""
    number = pd.to_numeric(str(value).removeprefix("seed_"), errors="coerce")
    return "unseeded" if pd.isna(number) or number == UNSEEDED else str(int(number))


def _model(key: tuple[str, str, str], path: str, scores: pd.DataFrame | None) -> TrackedRun:
    """One fitted model: its settings, scores, outcomes, loss curves, and where its artefacts are."""
    scene, method, seed = key
    rom, losses = (
        open_dataset(path, "rom"),
        open_dataset(Path(path).with_name("losses.nc"), "losses"),
    )
    params = {
        "scene": scene,
        "method": method,
        "seed": seed.removeprefix("seed_"),
        **_flat(json.loads(rom.attrs.get("settings", "{}"))),
    }
    metrics = {
        f"fit/{name}": float(rom[name])
        for name in ("mapping_seconds", "dynamics_seconds")
        if name in rom
    }
    tags = {
        "artefacts": str(Path(path).parent),
        "outcome.fit": str(rom["outcome"].values),
        **{
            name: str(rom.attrs[name])
            for name in ("source_digest", "versions")
            if name in rom.attrs
        },
    }
    return TrackedRun(
        " ".join(key), params, metrics | _metrics(scores), _curves(losses), tags | _outcomes(scores)
    )


def _reference(key: tuple[str, str, str], scores: pd.DataFrame) -> TrackedRun:
    """The full-order model of a scene: what it was asked too."""
    return TrackedRun(
        f"{key[0]} {key[1]}",
        {"scene": key[0], "method": key[1]},
        _metrics(scores),
        tags=_outcomes(scores),
    )


def _metrics(scores: pd.DataFrame | None) -> dict[str, float]:
    if scores is None:
        return {}
    return {
        f"{row.experiment}/{row.metric}": float(row.value)
        for row in scores.itertuples()
        if pd.notna(row.metric)
    }


def _outcomes(scores: pd.DataFrame | None) -> dict[str, str]:
    return (
        {}
        if scores is None
        else {f"outcome.{row.experiment}": str(row.outcome) for row in scores.itertuples()}
    )


def _curves(losses: xr.Dataset) -> dict[str, tuple]:
    """Loss curves by name: losses/train_total, ..."""
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
