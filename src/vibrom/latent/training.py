"""The training loop of the autoencoders.

All that is learnt is one vector, so that a checkpoint is that vector, the optimiser's state and the
generator. On a GPU nothing is fetched between two rows of the history.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import partial
from hashlib import sha256
from math import ceil, cos, pi
from typing import Any, Literal

import numpy as np

from vibrom.latent.autoencoder import Autoencoder
from vibrom.latent.backend import torch
from vibrom.latent.graphs import captured
from vibrom.latent.learner import Dynamics, Learner
from vibrom.latent.optimisers import OPTIMISERS, Optimiser
from vibrom.models.training import MethodError, Monitor, TrainingDiverged

ROWS = 100  # of the history, about
CHECKPOINT_SECONDS = 5.0

Profile = Literal["one_cycle", "constant"]
Precision = Literal["float32", "float64"]
OptimiserName = Literal["soap", "adam"]


@dataclass(frozen=True)
class Schedule:
    """How long and how fast."""

    epochs: int
    batch: int  # samples in a step; 0: all
    shuffle: bool
    learning_rate: float  # the largest
    profile: Profile
    precision: Precision
    optimiser: OptimiserName
    shift: float = 1.0  # of soap

    def rate_at(self, step: int, steps: int) -> float:
        """Learning rate of this step: constant, or up by cosine over the first 30 % and down to
        nothing.
        """
        if self.profile == "constant":
            return self.learning_rate
        top = 0.3 * steps
        if step < top:
            return self.learning_rate * (0.04 + 0.96 * (1.0 - cos(pi * step / top)) / 2.0)
        return self.learning_rate * (
            1e-4 + (1.0 + cos(pi * (step - top) / max(steps - top, 1.0))) / 2.0
        )


def pick_device(name: str) -> torch.device:
    """The device cpu, cuda or cuda:<number>; auto: cuda where there is one."""
    if name == "auto":
        name = "cuda" if torch.cuda.is_available() else "cpu"
    if name.startswith("cuda") and not torch.cuda.is_available():
        raise MethodError(f"device is {name!r}, but torch finds no such device; give cpu or auto")
    return torch.device(name)


def warm_up(device: torch.device) -> None:
    """Five steps on next to nothing: torch loads and compiles what that needs at its first use, and
    that is no training time.
    """
    learner = Learner(
        Autoencoder((2, 2, 1), "silu"), None, torch.float32, device, torch.Generator()
    )
    nothing = torch.zeros(1, 1, 2, device=device)
    schedule = Schedule(5, 0, False, 1e-3, "constant", "float32", "soap")
    for _ in epochs(learner, made(schedule, learner), schedule, nothing):
        pass


def made(schedule: Schedule, learner: Learner) -> Optimiser:
    """The schedule's optimiser for what the learner learns."""
    own = {"shift": schedule.shift} if schedule.optimiser == "soap" else {}
    return OPTIMISERS[schedule.optimiser](learner.vector, learner.shapes, **own)


def epochs(
    learner: Learner,
    optimiser: Optimiser,
    schedule: Schedule,
    c: torch.Tensor,
    generator: torch.Generator | None = None,
    first: int = 0,
) -> Iterator[tuple[int, torch.Tensor]]:
    """Trains on c (3, sample, k), and yields after every epoch its number, from one, and its mean
    losses.

    No value is fetched, so a GPU never waits for the host; samples, rate, weights, gradient,
    moments and losses stay where they are in memory, so a step is the same work on the same
    addresses every time, and a GPU gets it as one graph.
    """
    samples = c.shape[1]
    batch = min(schedule.batch or samples, samples)
    batches = ceil(samples / batch)
    steps = schedule.epochs * batches
    rates = torch.tensor(
        [schedule.rate_at(step, steps) for step in range(steps)], dtype=torch.float64
    ).to(c.device)
    rate = torch.zeros_like(rates[0])
    sums = torch.zeros(len(learner.terms), dtype=c.dtype, device=c.device)

    def step(part: torch.Tensor) -> None:
        sums.add_(learner.losses(part), alpha=part.shape[1] / samples)
        optimiser.step(learner.gradient, rate)

    # All batches have one size, save perhaps the last.
    sizes = {batch, samples - (batches - 1) * batch}
    places = {size: c if batches == 1 else c[:, :size].clone() for size in sizes}
    changed = [learner.vector, sums, *optimiser.state.values()]
    learn = {
        size: captured(partial(step, place), changed, c.device) for size, place in places.items()
    }
    for epoch in range(first, schedule.epochs):
        order = (
            torch.randperm(samples, generator=generator).to(c.device) if schedule.shuffle else None
        )
        sums.zero_()
        for index in range(batches):
            begin, number = index * batch, epoch * batches + index
            size = min(batch, samples - begin)
            if batches > 1:
                span = slice(begin, begin + size)
                places[size].copy_(c[:, span] if order is None else c[:, order[span]])
            rate.copy_(rates[number])
            learn[size]()
            if optimiser.every and (number + 1) % optimiser.every == 0:
                optimiser.turn()
        yield epoch + 1, sums


def train(
    autoencoder: Autoencoder,
    dynamics: Dynamics | None,
    schedule: Schedule,
    stack: np.ndarray,
    *,
    seed: int,
    device: torch.device,
    monitor: Monitor,
    label: str = "",
) -> tuple[list[np.ndarray], np.ndarray]:
    """The weights and Xi that follow from samples (3, m, k). `label` and the samples tell the
    checkpoints of one training from those of another.
    """
    dtype = getattr(torch, schedule.precision)
    generator = torch.Generator().manual_seed(seed)
    learner = Learner(autoencoder, dynamics, dtype, device, generator)
    label = f"{label} {sha256(np.ascontiguousarray(stack)).hexdigest()}"
    run = Run(learner, made(schedule, learner), generator, schedule.epochs, monitor, label)
    first = run.resumed()
    c = torch.tensor(stack, dtype=dtype, device=device)
    every, saved = ceil(schedule.epochs / ROWS), time.monotonic()
    for epoch, sums in epochs(learner, run.optimiser, schedule, c, generator, first):
        if epoch % every == 0 or epoch in (1, schedule.epochs):
            run.record(epoch, sums)
        if time.monotonic() - saved > CHECKPOINT_SECONDS:
            monitor.checkpoint(run.state(epoch))
            saved = time.monotonic()
    return learner.learnt()


@dataclass
class Run:
    """A training that keeps its history, and can be interrupted."""

    learner: Learner
    optimiser: Optimiser
    generator: torch.Generator
    epochs: int
    monitor: Monitor
    label: str
    history: dict[str, list[float]] = field(default_factory=dict)

    def record(self, epoch: int, sums: torch.Tensor) -> None:
        """One row of the history; a loss that is not finite ends the training."""
        row = {f"train_{name}": value for name, value in zip(self.learner.terms, sums.tolist())}
        if not np.isfinite(row["train_total"]):
            raise TrainingDiverged(
                f"the loss is {row['train_total']} at epoch {epoch} of {self.epochs}; "
                "lower learning_rate"
            )
        for name, value in {"epoch": epoch, **row}.items():
            self.history.setdefault(name, []).append(value)
        self.monitor.epoch(epoch, self.epochs, row)

    def state(self, epoch: int) -> dict[str, Any]:
        """All that the rest of the training depends on, as arrays, numbers and strings."""
        remembered = {
            f"optimiser_{name}": value.cpu().numpy().copy()
            for name, value in self.optimiser.state.items()
        }
        return {
            "label": self.label,
            "epoch": epoch,
            "parameters": self.learner.vector.cpu().numpy().copy(),
            **remembered,
            "generator": self.generator.get_state().numpy().copy(),
            **{f"history_{name}": np.array(values) for name, values in self.history.items()},
        }

    def resumed(self) -> int:
        """Resumes an interrupted training: restores its state, tells the monitor the rows it had,
        and gives the epoch to resume from; 0 where there is none.
        """
        state = self.monitor.restore()
        if state is None or str(state["label"]) != self.label:
            return 0
        self.learner.vector.copy_(torch.from_numpy(np.asarray(state["parameters"])))
        for name, value in self.optimiser.state.items():
            value.copy_(torch.from_numpy(np.asarray(state[f"optimiser_{name}"])))
        self.generator.set_state(torch.from_numpy(np.array(state["generator"])))
        self.history |= {
            name.removeprefix("history_"): np.asarray(values).tolist()
            for name, values in state.items()
            if name.startswith("history_")
        }
        for row in zip(*self.history.values()):
            values = dict(zip(self.history, row))
            self.monitor.epoch(int(values.pop("epoch")), self.epochs, values)
        return int(state["epoch"])
