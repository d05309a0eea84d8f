"""Training data -> rom.nc and losses.nc: one method learns one model, tells how it goes, and can be
interrupted.
"""

from __future__ import annotations

import os
import sys
import time
from contextlib import contextmanager
from pathlib import Path
from zipfile import BadZipFile

import numpy as np
import xarray as xr

from vibrom.artefacts.data import label, open_dataset, save_dataset, variable
from vibrom.artefacts.progress import bar
from vibrom.methods import method_from_settings
from vibrom.models.recorded import structure as operators
from vibrom.models.recorded import trajectory
from vibrom.models.rom import rom_from_dataset
from vibrom.models.training import MethodError, Monitor, Training, TrainingDiverged


class FileMonitor(Monitor):
    """Times the phases, keeps the loss history, shows progress and keeps the last checkpoint at
    `path` (.npz, no pickle).
    """

    def __init__(self, path: str | None, title: str):
        self.path, self.title = None if path is None else Path(path), title
        self.seconds, self.history = {"mapping": 0.0, "dynamics": 0.0}, []
        self._bar = self._advance = None
        self._done, self._began = 0, time.perf_counter()

    @contextmanager
    def phase(self, name: str):
        self._began = time.perf_counter()
        try:
            yield
        finally:
            self.seconds[name] += time.perf_counter() - self._began

    def epoch(self, epoch: int, epochs: int, losses: dict[str, float]) -> None:
        self.history.append({"epoch": epoch, **losses})
        if self._bar is None:
            self._bar = bar(self.title, epochs, "epochs")
            self._advance = self._bar.__enter__()
        self._advance(epoch - self._done)
        self._done = epoch

    def restore(self):
        if self.path is None or not self.path.exists():
            return None
        try:
            with np.load(self.path, allow_pickle=False) as stored:
                state = {name: stored[name] for name in stored.files}
        except (OSError, ValueError, KeyError, EOFError, BadZipFile):
            return None  # torn while it was written: the training starts anew
        self.seconds["mapping"] += float(state.pop("spent_seconds", 0.0))
        return state

    def checkpoint(self, state) -> None:
        if self.path is None:
            return
        self.path.parent.mkdir(parents=True, exist_ok=True)
        partial = self.path.with_name(f".{self.path.stem}.partial.npz")
        spent = self.seconds["mapping"] + time.perf_counter() - self._began
        try:
            np.savez(partial, **state, spent_seconds=spent)
            os.replace(partial, self.path)
        except OSError as error:
            print(f"{self.title}: no checkpoint ({error}); the training goes on", file=sys.stderr)
        finally:
            partial.unlink(missing_ok=True)

    def close(self) -> None:
        if self._bar is not None:
            self._bar.__exit__(None, None, None)


def run(
    *,
    structure: str,
    train: str,
    rom: str,
    losses: str,
    scene_name: str,
    method: str,
    kind: str | None = None,
    settings: dict,
    seed: int | None,
    device: str,
    provenance: dict,
    start: str | None = None,
    checkpoint: str | None = None,
) -> None:
    known = open_dataset(structure, "structure")
    monitor = FileMonitor(
        checkpoint, f"{scene_name}: {method}" + ("" if seed is None else f", seed {seed}")
    )
    begun = open_dataset(start, "rom") if start else None
    outcome, reason, fitted = "ok", "", xr.Dataset()
    motion = open_dataset(train, "trajectory")
    failed = float(motion["failed_at"])
    if str(motion["outcome"].item()) != "ok":
        outcome, reason = (
            "reference_failed",
            f"the full-order training run stopped at {failed:.4g} s without convergence; raise time.steps_per_period",
        )
    elif begun is not None and str(begun["outcome"].item()) != "ok":
        outcome, reason = (
            str(begun["outcome"].item()),
            f"the model that it starts from: {begun.attrs['reason']}",
        )
    else:
        try:
            chosen = method_from_settings(kind or method, settings)
        except MethodError as error:
            raise MethodError(f"config/methods/{method}.yaml: settings: {error}") from error
        training = Training(
            (trajectory(motion),),
            operators(known),
            seed,
            device,
            None if begun is None else rom_from_dataset(begun),
            monitor,
        )
        try:
            fitted = chosen.learn(training).to_dataset()
        except TrainingDiverged as diverged:
            outcome, reason = "training_diverged", str(diverged)
        finally:
            monitor.close()
    # A model that starts from another one has needed that one's mapping too.
    before = 0.0 if begun is None else float(begun["mapping_seconds"])
    fitted = fitted.assign(
        {
            "outcome": variable((), outcome, "1", "how the fit ended"),
            "mapping_seconds": variable(
                (),
                before + monitor.seconds["mapping"],
                "s",
                "wall time to learn the mapping, that of a model to start from included",
            ),
            "dynamics_seconds": variable(
                (),
                monitor.seconds["dynamics"],
                "s",
                "wall time to learn the dynamics after the mapping",
            ),
        }
    )
    names = dict(scene=scene_name, method=method, seed=seed, settings=settings, reason=reason)
    save_dataset(label(loss_history(monitor.history), "losses", **names), losses, provenance)
    save_dataset(label(fitted, "rom", **names), rom, provenance)
    if checkpoint:
        Path(checkpoint).unlink(missing_ok=True)


def loss_history(rows: list[dict[str, float]]) -> xr.Dataset:
    """One variable a loss term, one entry a recorded epoch; none for a method that does not
    iterate.
    """
    names = list(rows[0]) if rows else ["epoch", "train_total"]
    columns = {name: np.array([row[name] for row in rows], dtype=float) for name in names}
    terms = {
        name: variable("epoch", values, "1", f"loss: {name.replace('_', ' ')}")
        for name, values in columns.items()
        if name != "epoch"
    }
    return xr.Dataset(
        terms,
        coords={
            "epoch": variable(
                "epoch", columns["epoch"].astype(int), "1", "epoch of training, counted from one"
            )
        },
    )
