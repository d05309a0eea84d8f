"""The training loop of the autoencoders.

    L = |c - v(w(c))|^2 + l1 |c'' - d2/dtau2 v(z)|^2 + l2 |z'' - f(z, z')|^2 + l3 |Xi|_1,    f = R0 (z, z') + Xi Theta(z, z')

means over samples of squared norms, with z'' = f in the second term; without dynamics only the first is left. All that is learnt is one vector,
so that a checkpoint is that vector, the optimiser's two moments and the generator.
"""

import time
from dataclasses import dataclass
from hashlib import sha256
from math import ceil, cos, pi

import numpy as np
import torch

from vibrom.latent.autoencoder import Autoencoder, monomials
from vibrom.rom import MethodError, Monitor, TrainingDiverged

ROWS = 300
CHECKPOINT_SECONDS = 5.0


@dataclass(frozen=True)
class Dynamics:
    """R0 (d, 2d) or None, exponents (l, 2d) of Theta, first value of Xi, how much faster than weights it moves, and the weights of the losses."""

    linear: np.ndarray | None
    powers: np.ndarray
    initial: float
    gain: float
    full: float
    reduced: float
    sparsity: float


@dataclass(frozen=True)
class Schedule:
    """How long and how fast; batch 0 takes all samples at once."""

    epochs: int
    batch: int
    shuffle: bool
    learning_rate: float
    rate: str
    precision: str

    def rate_at(self, step: int, steps: int) -> float:
        """Learning rate of this step: constant, or up by cosine over the first 30 % and down to nothing."""
        if self.rate == "constant":
            return self.learning_rate
        top = 0.3 * steps
        if step < top:
            return self.learning_rate * (0.04 + 0.96 * (1.0 - cos(pi * step / top)) / 2.0)
        return self.learning_rate * (1e-4 + (1.0 + cos(pi * (step - top) / max(steps - top, 1.0))) / 2.0)


def pick_device(name: str) -> torch.device:
    """cpu, cuda or whichever is there (auto)."""
    if name == "auto":
        name = "cuda" if torch.cuda.is_available() else "cpu"
    if name.startswith("cuda") and not torch.cuda.is_available():
        raise MethodError(f"device is {name!r}, but torch finds no such device; give cpu or auto")
    return torch.device(name)


def warm_up() -> None:
    """One step of an optimiser on nothing: torch loads and compiles what that needs at its first use, and that is no training time."""
    nothing = torch.zeros(1, requires_grad=True)
    nothing.square().sum().backward()
    torch.optim.Adam([nothing]).step()


class Learner:
    """Autoencoder, dynamics and their one vector of parameters."""

    def __init__(self, autoencoder: Autoencoder, dynamics: Dynamics | None, dtype: torch.dtype, device: torch.device, generator: torch.Generator):
        self.autoencoder, self.dynamics = autoencoder, dynamics
        parts = autoencoder.initial(generator)
        if dynamics:
            parts.append(torch.full((autoencoder.sizes[-1], len(dynamics.powers)), dynamics.initial / dynamics.gain, dtype=torch.float64))
            self.linear = None if dynamics.linear is None else torch.tensor(dynamics.linear, dtype=dtype, device=device)
        self.shapes = [part.shape for part in parts]
        self.vector = torch.cat([part.flatten() for part in parts]).to(dtype=dtype, device=device).requires_grad_()

    def parts(self) -> list[torch.Tensor]:
        return [part.view(shape) for part, shape in zip(self.vector.split([shape.numel() for shape in self.shapes]), self.shapes)]

    def losses(self, c: torch.Tensor) -> dict[str, torch.Tensor]:
        """Every term of the loss and their weighted `total`; c (3, sample, k)."""
        parts = self.parts()
        if self.dynamics is None:
            error = mean_square(c[0] - self.autoencoder.decode(self.autoencoder.encode(c[:1], parts), parts)[0])
            return {"total": error, "reconstruction": error}
        dynamics, coefficients = self.dynamics, self.dynamics.gain * parts[-1]
        z = self.autoencoder.encode(c, parts[:-1])
        y = torch.cat([z[0], z[1]], dim=-1)
        model = monomials(y, dynamics.powers) @ coefficients.T
        if self.linear is not None:
            model = model + y @ self.linear.T
        back = self.autoencoder.decode(torch.stack([z[0], z[1], model]), parts[:-1])
        terms = {"reconstruction": mean_square(c[0] - back[0]), "acceleration_full": mean_square(c[2] - back[2]),
                 "acceleration_reduced": mean_square(z[2] - model)}
        total = terms["reconstruction"] + dynamics.full * terms["acceleration_full"] + dynamics.reduced * terms["acceleration_reduced"]
        if dynamics.sparsity:
            total = total + dynamics.sparsity * coefficients.abs().sum()
        return {"total": total, **terms}


def mean_square(residual: torch.Tensor) -> torch.Tensor:
    return residual.square().sum(dim=-1).mean()


def train(autoencoder: Autoencoder, dynamics: Dynamics | None, schedule: Schedule, train_stack: np.ndarray, test_stack: np.ndarray | None,
          *, seed: int, device: torch.device, monitor: Monitor, label: str = "") -> list[np.ndarray]:
    """The learnt weights and, last, Xi. `label` and the data tell checkpoints of one training from those of another."""
    label = f"{label} {sha256(np.ascontiguousarray(train_stack)).hexdigest()}"
    dtype = {"float32": torch.float32, "float64": torch.float64}[schedule.precision]
    generator = torch.Generator().manual_seed(seed)
    learner = Learner(autoencoder, dynamics, dtype, device, generator)
    optimiser = torch.optim.Adam([learner.vector], lr=schedule.learning_rate)
    c = torch.tensor(train_stack, dtype=dtype, device=device)
    test = None if test_stack is None else torch.tensor(test_stack, dtype=dtype, device=device)
    samples = c.shape[1]
    batch = min(schedule.batch or samples, samples)
    batches = ceil(samples / batch)
    every = ceil(schedule.epochs / ROWS)
    history: dict[str, list[float]] = {}
    first = _restore(monitor, label, learner, optimiser, generator, history, schedule.epochs)
    saved = time.monotonic()
    for epoch in range(first, schedule.epochs):
        order = torch.randperm(samples, generator=generator).to(device) if schedule.shuffle else None
        sums: dict[str, float] = {}
        for index in range(batches):
            span = slice(index * batch, (index + 1) * batch)
            part = c if batches == 1 else c[:, span] if order is None else c[:, order[span]]
            for group in optimiser.param_groups:
                group["lr"] = schedule.rate_at(epoch * batches + index, schedule.epochs * batches)
            terms = learner.losses(part)
            learner.vector.grad = None
            terms["total"].backward()
            optimiser.step()
            share = part.shape[1] / samples
            for name, term in terms.items():
                sums[name] = sums.get(name, 0.0) + share * term.item()
        if not np.isfinite(sums["total"]):
            raise TrainingDiverged(f"the loss is {sums['total']} at epoch {epoch + 1} of {schedule.epochs}; lower learning_rate")
        if (epoch + 1) % every == 0 or epoch in (0, schedule.epochs - 1):
            _record(learner, sums, test, epoch + 1, schedule.epochs, history, monitor)
        if time.monotonic() - saved > CHECKPOINT_SECONDS:
            monitor.checkpoint(_state(label, epoch + 1, learner, optimiser, generator, history))
            saved = time.monotonic()
    parts = [part.detach().cpu().double().numpy() for part in learner.parts()]
    return parts if dynamics is None else [*parts[:-1], dynamics.gain * parts[-1]]


def _record(learner: Learner, sums: dict[str, float], test, epoch: int, epochs: int, history: dict[str, list[float]], monitor: Monitor) -> None:
    row = {f"train_{name}": value for name, value in sums.items()}
    if test is not None:
        with torch.no_grad():
            row |= {f"test_{name}": value.item() for name, value in learner.losses(test).items()}
    for name, value in {"epoch": epoch, **row}.items():
        history.setdefault(name, []).append(value)
    monitor.epoch(epoch, epochs, row)


def _state(label: str, epoch: int, learner: Learner, optimiser, generator: torch.Generator, history: dict[str, list[float]]) -> dict:
    """All that the rest of the training depends on, as arrays, numbers and strings."""
    moments = optimiser.state[learner.vector]
    return {"label": label, "epoch": epoch, "parameters": learner.vector.detach().cpu().numpy().copy(), "step": float(moments["step"]),
            "mean": moments["exp_avg"].cpu().numpy().copy(), "square": moments["exp_avg_sq"].cpu().numpy().copy(),
            "generator": generator.get_state().numpy().copy(), **{f"history_{name}": np.array(values) for name, values in history.items()}}


def _restore(monitor: Monitor, label: str, learner: Learner, optimiser, generator: torch.Generator, history: dict[str, list[float]], epochs: int) -> int:
    """Takes up an interrupted training: puts everything back, tells the monitor the rows it had, and gives the epoch to go on from."""
    state = monitor.restore()
    if state is None or str(state["label"]) != label:
        return 0
    vector = learner.vector
    with torch.no_grad():
        vector.copy_(torch.from_numpy(np.asarray(state["parameters"])))
    optimiser.state[vector] = {"step": torch.tensor(float(state["step"])), "exp_avg": torch.from_numpy(np.array(state["mean"])).to(vector.device),
                               "exp_avg_sq": torch.from_numpy(np.array(state["square"])).to(vector.device)}
    generator.set_state(torch.from_numpy(np.array(state["generator"])))
    history |= {name.removeprefix("history_"): np.asarray(values).tolist() for name, values in state.items() if name.startswith("history_")}
    for row in zip(*history.values()):
        values = dict(zip(history, row))
        monitor.epoch(int(values.pop("epoch")), epochs, values)
    return int(state["epoch"])
