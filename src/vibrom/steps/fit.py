"""Training data -> rom.nc and losses.nc: one method learns one model, shows how far it is, and can
be interrupted.
"""

from __future__ import annotations

import hashlib
import io
import sys
from dataclasses import dataclass, replace
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from vibrom.artefacts.data import label, open_dataset, save_dataset, variable
from vibrom.artefacts.files import DataError, write
from vibrom.artefacts.outcome import Outcome
from vibrom.artefacts.progress import bar
from vibrom.methods import method_from_settings
from vibrom.models.recorded import structure as operators
from vibrom.models.recorded import trajectories
from vibrom.models.rom import rom_from_dataset
from vibrom.models.training import (
    Clock,
    MethodError,
    Monitor,
    Training,
    TrainingDiverged,
    Underdetermined,
    Unsupported,
)

if TYPE_CHECKING:
    from vibrom.models.method import Method
    from vibrom.models.rom import Rom
    from vibrom.term import Term

FITS, ENOUGH = 3, 0.5  # a fit is timed up to three times, or until that took half a second

DIGEST = hashlib.sha256().digest_size


@dataclass(frozen=True)
class Recipe:
    """Which method learns what, and how."""

    scene: str
    method: str  # the name in config/methods
    kind: str  # the file of src/vibrom/methods
    settings: dict[str, Any]
    seed: int | None  # None: the method draws no random numbers
    device: str

    @property
    def title(self) -> str:
        """What the progress bar shows."""
        return f"{self.scene}: {self.method}" + ("" if self.seed is None else f", seed {self.seed}")


class FileMonitor(Monitor):
    """Keeps the loss history and shows progress; `path` is the place of the last checkpoint, None
    for none: the sha256 of an .npz without pickled objects, and the .npz.
    """

    def __init__(self, path: str | None, title: str):
        super().__init__()
        self.path, self.title = None if path is None else Path(path), title
        self.history: list[dict[str, float]] = []  # a row: epoch, and every term of the loss
        self._bar = self._advance = None
        self._done = 0

    def epoch(self, epoch: int, epochs: int, losses: dict[str, float]) -> None:
        """See Monitor."""
        self.history.append({"epoch": epoch, **losses})
        if self._bar is None:
            self._bar = bar(self.title, epochs, "epochs")
            self._advance = self._bar.__enter__()
        self._advance(epoch - self._done)
        self._done = epoch

    def restore(self) -> dict[str, Any] | None:
        """See Monitor."""
        if self.path is None or not self.path.exists():
            return None
        raw = self.path.read_bytes()
        digest, content = raw[:DIGEST], raw[DIGEST:]
        if hashlib.sha256(content).digest() != digest:
            print(f"{self.path}: damaged; the training starts again", file=sys.stderr)
            return None
        with np.load(io.BytesIO(content), allow_pickle=False) as stored:
            state = {name: stored[name] for name in stored.files}
        earlier = float(state.pop("spent_seconds", 0.0))
        self.seconds["total"] = self.seconds.get("total", 0.0) + earlier
        return state

    def checkpoint(self, state: dict[str, Any]) -> None:
        """See Monitor."""
        if self.path is None:
            return
        try:
            content = io.BytesIO()
            np.savez(content, **state, spent_seconds=self.spent("total"))
            write(self.path, hashlib.sha256(content.getvalue()).digest() + content.getvalue())
        except DataError as error:
            print(f"{self.title}: no checkpoint ({error}); the training resumes", file=sys.stderr)

    def close(self) -> None:
        """Ends the progress bar."""
        if self._bar is not None:
            self._bar.__exit__(None, None, None)


@dataclass(frozen=True)
class Fitted:
    """A stored model, or the outcome that stands for it."""

    model: xr.Dataset
    outcome: Outcome = Outcome.OK
    reason: str = ""  # empty where the outcome is ok


def run(
    *,
    structure: str,
    rom: str,
    losses: str,
    recipe: dict[str, Any],
    provenance: dict[str, str],
    train: str | None = None,
    scene: dict[str, Any] | None = None,
    start: str | None = None,
    checkpoint: str | None = None,
) -> None:
    """`recipe` are the fields of Recipe, `start` is the fitted model to start from. A method that
    asks for the equations of motion is given the blocks of the `scene` instead of `train`.
    """
    given = Recipe(**recipe)
    motion = open_dataset(train, "trajectory", lazy=True) if train else None
    known = open_dataset(structure, "structure")
    begun = open_dataset(start, "rom") if start else None
    monitor = FileMonitor(checkpoint, given.title)
    try:
        fitted = fit_or_reason(given, known, motion, begun, monitor, scene)
    finally:
        monitor.close()
    names = {
        "scene": given.scene,
        "method": given.method,
        "seed": given.seed,
        "settings": given.settings,
        "reason": fitted.reason,
    }
    # A model that starts from another one has needed that one's mapping too.
    before = 0.0 if begun is None else float(begun["mapping_seconds"])
    model = fitted.model.assign(
        outcome=variable((), str(fitted.outcome), "1", "how the fit ended"),
        **seconds(monitor, before, 0.0 if motion is None else float(motion["seconds"])),
    )
    save_dataset(label(loss_history(monitor.history), "losses", **names), losses, provenance)
    save_dataset(label(model, "rom", **names), rom, provenance)
    if checkpoint:
        Path(checkpoint).unlink(missing_ok=True)


def fit_or_reason(
    recipe: Recipe,
    known: xr.Dataset,
    motion: xr.Dataset | None,
    begun: xr.Dataset | None,
    monitor: Monitor,
    scene: dict[str, Any] | None = None,
) -> Fitted:
    """The model that the method learns from `motion`, or why there is none."""
    if motion is not None and not Outcome(str(motion["outcome"].item())).has_value:
        return Fitted(
            xr.Dataset(),
            Outcome.REFERENCE_FAILED,
            f"the full-order training run stopped at {float(motion['failed_at']):.4g} s; raise "
            "time.steps_per_period",
        )
    start_ended = Outcome.OK if begun is None else Outcome(str(begun["outcome"].item()))
    if not start_ended.has_value:
        reason = f"the model that it starts from: {begun.attrs['reason']}"
        return Fitted(xr.Dataset(), start_ended, reason)
    try:
        method = method_from_settings(recipe.kind, recipe.settings)
        if method.of_equations and scene is None:
            raise Unsupported(
                f"{recipe.method} is made from equations of motion, and a recorded scene has none"
            )
        method.prepare(recipe.device)
        training = Training(
            () if motion is None else trajectories(motion, lazy=True),
            operators(known),
            recipe.seed,
            recipe.device,
            None if begun is None else rom_from_dataset(begun),
            monitor,
            None if scene is None else equations_of_motion(scene),
        )
        return Fitted(timed(method, training).to_dataset())
    except TrainingDiverged as diverged:
        return Fitted(xr.Dataset(), Outcome.TRAINING_DIVERGED, str(diverged))
    except Unsupported as error:
        return Fitted(xr.Dataset(), Outcome.SKIPPED, str(error))
    except Underdetermined as error:
        return Fitted(xr.Dataset(), Outcome.UNDERDETERMINED, str(error))
    except MethodError as error:
        where = f"{recipe.method} in scene {recipe.scene}"
        raise MethodError(f"{where}: {error}") from error


def timed(method: Method, training: Training) -> Rom:
    """The model. A quick fit without a seed is timed a few times: other jobs may run beside it."""
    began, model = training.monitor, method.learn(training)
    spent, fits = began.spent("total"), 1
    while training.seed is None and fits < FITS and spent < ENOUGH:
        again, fits = Clock(), fits + 1
        method.learn(replace(training, monitor=again))
        spent += again.spent("total")
        if again.spent("total") < began.spent("total"):
            began.seconds = again.seconds
    return model


def equations_of_motion(scene: dict[str, Any]) -> Term:
    """Assembled as the full order has them; that code is not behind other methods."""
    space, effects = (import_module(f"vibrom.{name}") for name in ("bodies.space", "effects"))
    return effects.assemble(space.build(scene["body"]), scene["effects"])


def seconds(monitor: Monitor, before: float, data: float) -> dict[str, xr.Variable]:
    """Wall times of mapping and dynamics, which together are all that the fit took; `before` [s]
    was spent on the mapping of the model to start from, and `data` on the training data.
    """
    dynamics = monitor.spent("dynamics")
    mapping = before + monitor.spent("total") - dynamics
    return {
        "data_seconds": variable((), data, "s", "wall time of the training data"),
        "mapping_seconds": variable(
            (),
            mapping,
            "s",
            "wall time to learn the mapping, that of a model to start from included",
        ),
        "dynamics_seconds": variable(
            (), dynamics, "s", "wall time to learn the dynamics after the mapping"
        ),
    }


def loss_history(rows: list[dict[str, float]]) -> xr.Dataset:
    """One variable a loss term, one entry a recorded epoch; none for a method that does not
    iterate.
    """
    names = list(rows[0]) if rows else ["epoch", "train_total"]
    columns = {name: np.array([row[name] for row in rows], dtype=float) for name in names}
    epochs = columns.pop("epoch").astype(int)
    terms = {
        name: variable("epoch", values, "1", f"loss: {name.replace('_', ' ')}")
        for name, values in columns.items()
    }
    epoch = variable("epoch", epochs, "1", "epoch of training, counted from one")
    return xr.Dataset(terms, coords={"epoch": epoch})
