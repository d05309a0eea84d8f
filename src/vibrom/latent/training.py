"""The training loop of the autoencoders.

    L = |c - v(w(c))|^2 + l1 |G (c'' - d2/dtau2 v(z))|^2 + l2 |z'' - f(z, z')|^2 + l3 |Xi|_1,    f =
    R0 (z, z') + Xi Theta(z, z')

means over samples of squared norms, with z'' = f in the second term; without dynamics only the
first is left. G is one where no norm is given. All that is learnt is one vector, so that a
checkpoint is that vector, the optimiser's state and the generator. On a GPU nothing is fetched
between two rows of the history.
"""

import time
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from hashlib import sha256
from math import ceil, cos, pi

import numpy as np
import torch

from vibrom.latent.autoencoder import Autoencoder, Polynomial
from vibrom.latent.graphs import captured
from vibrom.latent.optimisers import OPTIMISERS, Adam, Soap
from vibrom.models.training import MethodError, Monitor, TrainingDiverged

ROWS = 100
CHECKPOINT_SECONDS = 5.0


@dataclass(frozen=True)
class Dynamics:
    """R0 (d, 2d) or None, exponents (l, 2d) of Theta, first value of Xi, how much faster than
    weights it moves, the weights of the losses, and G (k, k) or None.
    """

    linear: np.ndarray | None
    powers: np.ndarray
    initial: float
    gain: float
    full: float
    reduced: float
    sparsity: float
    norm: np.ndarray | None = None


@dataclass(frozen=True)
class Schedule:
    """How long and how fast; batch 0 takes all samples at once."""

    epochs: int
    batch: int
    shuffle: bool
    learning_rate: float
    rate: str
    precision: str
    optimiser: str

    def rate_at(self, step: int, steps: int) -> float:
        """Learning rate of this step: constant, or up by cosine over the first 30 % and down to
        nothing.
        """
        if self.rate == "constant":
            return self.learning_rate
        top = 0.3 * steps
        if step < top:
            return self.learning_rate * (0.04 + 0.96 * (1.0 - cos(pi * step / top)) / 2.0)
        return self.learning_rate * (
            1e-4 + (1.0 + cos(pi * (step - top) / max(steps - top, 1.0))) / 2.0
        )


def pick_device(name: str) -> torch.device:
    """cpu, cuda or whichever is there (auto)."""
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
    for _ in epochs(learner, Soap(learner.vector, learner.shapes), schedule, nothing):
        pass


class Learner:
    """Autoencoder, dynamics, and one vector for all that is learnt: the weights, then Xi over its
    gain.
    """

    def __init__(
        self,
        autoencoder: Autoencoder,
        dynamics: Dynamics | None,
        dtype: torch.dtype,
        device: torch.device,
        generator: torch.Generator,
    ):
        self.autoencoder, self.dynamics = autoencoder, dynamics
        parts = autoencoder.initial(generator)
        if dynamics:
            parts.append(
                torch.full(
                    (autoencoder.sizes[-1], len(dynamics.powers)),
                    dynamics.initial / dynamics.gain,
                    dtype=torch.float64,
                )
            )
            self.linear = (
                None
                if dynamics.linear is None
                else torch.tensor(dynamics.linear, dtype=dtype, device=device)
            )
            self.norm = (
                None
                if dynamics.norm is None
                else torch.tensor(dynamics.norm, dtype=dtype, device=device)
            )
            self.polynomial = Polynomial(dynamics.powers, device)
        self.shapes = [part.shape for part in parts]
        self.vector = torch.cat([part.flatten() for part in parts]).to(dtype=dtype, device=device)
        self.gradient = torch.zeros_like(self.vector)
        self.parts, self.slopes = self._views(self.vector), self._views(self.gradient)
        self.terms = (
            ("total", "reconstruction", "acceleration_full", "acceleration_reduced")
            if dynamics
            else ("total", "reconstruction")
        )

    def _views(self, vector: torch.Tensor) -> list[torch.Tensor]:
        return [
            part.view(shape)
            for part, shape in zip(
                vector.split([shape.numel() for shape in self.shapes]), self.shapes
            )
        ]

    def learnt(self) -> list[np.ndarray]:
        """The weights and, last, Xi."""
        parts = [part.cpu().double().numpy().copy() for part in self.parts]
        return [*parts[:-1], self.dynamics.gain * parts[-1]] if self.dynamics else parts

    def losses(self, c: torch.Tensor, learn: bool = True) -> torch.Tensor:
        """The `terms` of the loss of c (3, sample, k); `learn`: and the gradient of the total."""
        twice = 2.0 / c.shape[1]
        if self.dynamics is None:
            z, there = self.autoencoder.encode(c[:1], self.parts)
            back, again = self.autoencoder.decode(z, self.parts)
            error = back.sub_(c[:1])
            mean = mean_square(error[0])
            if learn:
                g = self.autoencoder.decode_backward(
                    error.mul_(twice), z, self.parts, again, self.slopes
                )
                self.autoencoder.encode_backward(g, self.parts, there, self.slopes)
            return torch.stack([mean, mean])
        dynamics, coefficients = self.dynamics, self.dynamics.gain * self.parts[-1]
        z, there = self.autoencoder.encode(c, self.parts)
        y = torch.cat([z[0], z[1]], dim=-1)
        theta, rise = self.polynomial.monomials(y)
        model = theta @ coefficients.T
        if self.linear is not None:
            model.addmm_(y, self.linear.T)
        motion = torch.stack([z[0], z[1], model])
        back, again = self.autoencoder.decode(motion, self.parts)
        error, apart = back.sub_(c), z[2] - model
        if self.norm is not None:
            error[2] = error[2] @ self.norm.T
        means = torch.stack([mean_square(error[0]), mean_square(error[2]), mean_square(apart)])
        total = means[0] + dynamics.full * means[1] + dynamics.reduced * means[2]
        if dynamics.sparsity:
            total = total + dynamics.sparsity * coefficients.abs().sum()
        if learn:
            error[0].mul_(twice)
            error[1].zero_()  # no term asks for velocities
            error[2].mul_(twice * dynamics.full)
            if self.norm is not None:
                error[2] = error[2] @ self.norm
            g = self.autoencoder.decode_backward(error, motion, self.parts, again, self.slopes)
            apart.mul_(twice * dynamics.reduced)
            to_model = g[2] - apart
            torch.mm(to_model.T, theta, out=self.slopes[-1])
            if dynamics.sparsity:
                self.slopes[-1].add_(coefficients.sign(), alpha=dynamics.sparsity)
            self.slopes[-1].mul_(dynamics.gain)
            to_y = ((to_model @ coefficients) * rise).sum(dim=-1).T
            if self.linear is not None:
                to_y = to_y + to_model @ self.linear
            g[:2].add_(torch.stack(to_y.chunk(2, dim=-1)))
            g[2] = apart
            self.autoencoder.encode_backward(g, self.parts, there, self.slopes)
        return torch.cat([total[None], means])


def mean_square(residual: torch.Tensor) -> torch.Tensor:
    flat = residual.flatten()
    return flat.dot(flat) / len(residual)


def epochs(
    learner: Learner,
    optimiser: Adam,
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
    train_stack: np.ndarray,
    *,
    seed: int,
    device: torch.device,
    monitor: Monitor,
    label: str = "",
) -> list[np.ndarray]:
    """The learnt weights and, last, Xi. `label` and the data tell checkpoints of one training from
    those of another.
    """
    label = f"{label} {sha256(np.ascontiguousarray(train_stack)).hexdigest()}"
    dtype = getattr(torch, schedule.precision)
    generator = torch.Generator().manual_seed(seed)
    learner = Learner(autoencoder, dynamics, dtype, device, generator)
    optimiser = OPTIMISERS[schedule.optimiser](learner.vector, learner.shapes)
    c = torch.tensor(train_stack, dtype=dtype, device=device)
    every = ceil(schedule.epochs / ROWS)
    history: dict[str, list[float]] = {}
    first = _restore(monitor, label, learner, optimiser, generator, history, schedule.epochs)
    saved = time.monotonic()
    for epoch, sums in epochs(learner, optimiser, schedule, c, generator, first):
        if epoch % every == 0 or epoch in (1, schedule.epochs):
            _record(learner, sums, epoch, schedule.epochs, history, monitor)
        if time.monotonic() - saved > CHECKPOINT_SECONDS:
            monitor.checkpoint(_state(label, epoch, learner, optimiser, generator, history))
            saved = time.monotonic()
    return learner.learnt()


def _record(
    learner: Learner,
    sums: torch.Tensor,
    epoch: int,
    epochs: int,
    history: dict[str, list[float]],
    monitor: Monitor,
) -> None:
    row = {f"train_{name}": value for name, value in zip(learner.terms, sums.tolist())}
    if not np.isfinite(row["train_total"]):
        raise TrainingDiverged(
            f"the loss is {row['train_total']} at epoch {epoch} of {epochs}; lower learning_rate"
        )
    for name, value in {"epoch": epoch, **row}.items():
        history.setdefault(name, []).append(value)
    monitor.epoch(epoch, epochs, row)


def _state(
    label: str,
    epoch: int,
    learner: Learner,
    optimiser: Adam,
    generator: torch.Generator,
    history: dict[str, list[float]],
) -> dict:
    """All that the rest of the training depends on, as arrays, numbers and strings."""
    remembered = {
        f"optimiser_{name}": value.cpu().numpy().copy() for name, value in optimiser.state.items()
    }
    return {
        "label": label,
        "epoch": epoch,
        "parameters": learner.vector.cpu().numpy().copy(),
        **remembered,
        "generator": generator.get_state().numpy().copy(),
        **{f"history_{name}": np.array(values) for name, values in history.items()},
    }


def _restore(
    monitor: Monitor,
    label: str,
    learner: Learner,
    optimiser: Adam,
    generator: torch.Generator,
    history: dict[str, list[float]],
    epochs: int,
) -> int:
    """Takes up an interrupted training: puts everything back, tells the monitor the rows it had,
    and gives the epoch to go on from.
    """
    state = monitor.restore()
    if state is None or str(state["label"]) != label:
        return 0
    learner.vector.copy_(torch.from_numpy(np.asarray(state["parameters"])))
    for name, value in optimiser.state.items():
        value.copy_(torch.from_numpy(np.asarray(state[f"optimiser_{name}"])))
    generator.set_state(torch.from_numpy(np.array(state["generator"])))
    history |= {
        name.removeprefix("history_"): np.asarray(values).tolist()
        for name, values in state.items()
        if name.startswith("history_")
    }
    for row in zip(*history.values()):
        values = dict(zip(history, row))
        monitor.epoch(int(values.pop("epoch")), epochs, values)
    return int(state["epoch"])
