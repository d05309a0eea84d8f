"""The fitted models with their losses and scores, tables and figures -> the MLflow store."""

import json
import os
from pathlib import Path

import numpy as np
import xarray as xr

from vibrom import tracking
from vibrom.artefacts.outcome import Tally, worst
from vibrom.report.collection import FULL_ORDER, Collection, answered, outcome
from vibrom.report.scores import BALANCE, OFFLINE, Score, Scores, offline
from vibrom.tracking import Data, TrackedRun
from vibrom.tracking.stored_model import Parts
from vibrom.tracking.views import MODEL, OUTCOME


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
    scored = Scores.read(scores)
    runs = [_model(collection, scored, *key[:3]) for key in collection.loaders if key.name == "rom"]
    for scene in collection.scenes:
        mine = [row for row in scored.rows if row[:2] == (scene, FULL_ORDER)]
        if mine:
            runs.append(_full_order(collection, scene, mine))
    files = {"tables": tables, "figures": figures, "": [scores]}
    tags = {"role": "summary", **provenance}
    note = "Tables, figures and scores of the whole run."
    runs.append(TrackedRun("summary", tags=tags, files=files, note=note))
    tracking.record(runs, store=store, artifacts=artifacts)
    print(f"{len(runs)} runs in {store}; `{tracking.command(store)}` shows them")


def _model(
    collection: Collection, scores: Scores, scene: str, method: str, seed: int | None
) -> TrackedRun:
    """One fitted model: settings, scores, outcomes, loss curves, and where its artefacts are."""
    rom, losses = (collection.find(scene, method, name, seed) for name in ("rom", "losses"))
    mine = [row for row in scores.rows if row[:3] == (scene, method, seed)]
    whose = "unseeded" if seed is None else seed
    chosen = _flat(json.loads(rom.attrs.get("settings", "{}")))
    fit = {
        f"fit/{name}": float(rom[name])
        for name in ("data_seconds", "mapping_seconds", "dynamics_seconds")
        if name in rom
    }
    made_by = {
        name: str(rom.attrs[name]) for name in ("source_digest", "versions") if name in rom.attrs
    }
    source = Path(rom.encoding["source"])
    ends = {OUTCOME: worst(_endings(rom, mine)), "outcome.fit": outcome(rom).value}
    name = f"{scene} {method} {whose if seed is None else f'seed_{seed}'}"
    return TrackedRun(
        name,
        {"scene": scene, "method": method, "seed": whose, **chosen},
        fit | _metrics(mine) | {"offline_s": _offline(scores, scene, method, seed)},
        _curves(losses),
        {"artefacts": os.path.relpath(source.parent), MODEL: f"{scene} {method}"}
        | {**ends, **made_by, **_outcomes(mine)},
        note=f"{method} in case {scene}: fitted, then evaluated on "
        f"{', '.join(dict.fromkeys(row.experiment for row in mine))}. Its artefacts lie in "
        f"`{os.path.relpath(source.parent)}`.",
        began=source.stat().st_mtime - sum(fit.values()),
        seconds=sum(fit.values()) + _seconds(mine),
        data=_data(collection, scene),
        model=_parts(collection, scene, method, seed),
    )


def _full_order(collection: Collection, scene: str, rows: list[Score]) -> TrackedRun:
    """The reference of a scene."""
    return TrackedRun(
        f"{scene} {FULL_ORDER}",
        {"scene": scene, "method": FULL_ORDER},
        _metrics(rows),
        tags=_outcomes(rows)
        | {OUTCOME: worst(one for row in rows for one in row.outcome)}
        | {MODEL: f"{scene} {FULL_ORDER}"},
        note=f"The full-order model of case {scene}, which the methods are compared with.",
        seconds=_seconds(rows),
        data=_data(collection, scene),
    )


def _data(collection: Collection, scene: str) -> tuple[Data, ...]:
    """The recorded decays of a scene, each with the digest of its content."""
    found = []
    for role, context in (("train", "training"), ("test", "evaluation")):
        record = collection.find(scene, FULL_ORDER, role)
        if record is not None:
            digest = str(record.attrs.get("content", "unknown"))[:36]
            source = os.path.relpath(record.encoding["source"])
            found.append(Data(f"{scene} {role}", digest, source, context))
    return tuple(found)


def _parts(collection: Collection, scene: str, method: str, seed: int | None) -> Parts | None:
    """What predicts the decay again; None of a model that predicted none."""
    rom, decay = (collection.find(scene, method, name, seed) for name in ("rom", "decay"))
    structure, record = (collection.find(scene, FULL_ORDER, name) for name in ("structure", "test"))
    if structure is None or record is None or not answered(decay):
        return None
    step = float(record["time"][1] - record["time"][0])
    return Parts(
        rom.encoding["source"],
        structure.encoding["source"],
        json.loads(decay.attrs["settings"]),
        round(float(record["period"]) / step),
    )


def _endings(rom: xr.Dataset, rows: list[Score]) -> list[str]:
    """Of the fit and of all answers; whether a run is in balance has a tag of its own."""
    answers = (row for row in rows if row.experiment != BALANCE)
    return [outcome(rom), *(one for row in answers for one in row.outcome)]


def _seconds(rows: list[Score]) -> float:
    """Of all answers; one that took no time that is known counts nothing."""
    spent = {row.experiment: row.seconds for row in rows}
    return float(np.nansum([*spent.values(), 0.0]))


def _offline(scores: Scores, scene: str, method: str, seed: int | None) -> float:
    """Seconds before the first answer."""
    return offline({name: scores.value(scene, method, seed, "run_times", name) for name in OFFLINE})


def _metrics(rows: list[Score]) -> dict[str, float]:
    return {f"{row.experiment}/{row.metric}": row.value for row in rows}


def _outcomes(rows: list[Score]) -> dict[str, str]:
    tallies: dict[str, Tally] = {}
    for row in rows:
        # The scores of an experiment end alike; the runs of a balance each for itself.
        if row.experiment == BALANCE:
            tallies.setdefault(BALANCE, Tally()).update(row.outcome)
        else:
            tallies[row.experiment] = row.outcome
    return {f"outcome.{name}": str(tally) for name, tally in tallies.items()}


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
