"""One training: its clock, stopped now and then to evaluate the model on the test decay, which no
training sees. Who takes the steps is exchangeable.
"""

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path

import numpy as np
import torch

from benchmarks.table import NAN
from vibrom.artefacts.data import open_dataset
from vibrom.latent.learner import Learner
from vibrom.latent.optimisers import OPTIMISERS
from vibrom.latent.training import Schedule, epochs
from vibrom.methods import method_from_settings
from vibrom.models.measures import nmte_percent
from vibrom.models.recorded import structure, trajectory
from vibrom.models.rollout import Integrator, decode_displacement, rollout
from vibrom.models.rom import Rom
from vibrom.models.training import Training, Trajectory

LOOKS = 24  # at an error curve
ROUNDS = 3  # of each training; their median clock counts


@dataclass
class Curve:
    """What one training has reached, at several looks."""

    seconds: list[float] = field(default_factory=list)  # to have that model
    reconstruction: list[float] = field(default_factory=list)  # percent
    decay: list[float] = field(default_factory=list)  # percent
    corrected: list[float] = field(default_factory=list)  # percent, decay of SPLIT+ on its networks

    def until(self, errors: list[float], bound: float) -> float:
        """Seconds from which on the error is below; NaN if it never stays so."""
        below = np.array(errors) <= bound
        last = len(below) - int(np.argmin(below[::-1])) if not below.all() else 0
        return self.seconds[last] if last < len(below) else NAN


def motion(scene: str, role: str) -> Trajectory:
    path = Path("results") / scene / "full_order" / f"{role}.nc"
    return trajectory(open_dataset(path, "trajectory"))


@cache
def data(scene: str) -> Training:
    path = Path("results") / scene / "full_order" / "structure.nc"
    known = structure(open_dataset(path, "structure"))
    return Training((motion(scene, "train"),), known, seed=0)


@cache
def test_motion(scene: str) -> Trajectory:
    return motion(scene, "test")


def reconstruction(rom: Rom, scene: str) -> float:
    test = test_motion(scene)
    return nmte_percent(test.displacement, decode_displacement(rom, rom.encode(test.state)))


def decay(rom: Rom, scene: str) -> float:
    test = test_motion(scene)
    run = rollout(rom, rom.encode(test.state[:1]), (test.time - test.time[0])[None], Integrator())
    return nmte_percent(test.displacement, decode_displacement(rom, run.reduced[0]))


# Trains, and yields the number of steps done.
Steps = Callable[[Learner, Schedule, torch.Tensor], Iterator[int]]


def soap_or_adam(learner: Learner, schedule: Schedule, c: torch.Tensor) -> Iterator[int]:
    for epoch, _ in epochs(
        learner, OPTIMISERS[schedule.optimiser](learner.vector, learner.shapes), schedule, c
    ):
        yield epoch


def lbfgs(learner: Learner, schedule: Schedule, c: torch.Tensor) -> Iterator[int]:
    """Adam first, then L-BFGS; a step of that is one evaluation of the loss."""
    first = 200
    for epoch, _ in epochs(
        learner,
        OPTIMISERS["adam"](learner.vector, learner.shapes),
        replace(schedule, epochs=first),
        c,
    ):
        yield epoch
    done = first
    optimiser = torch.optim.LBFGS(
        [learner.vector],
        max_iter=20,
        max_eval=25,
        history_size=50,
        line_search_fn="strong_wolfe",
        tolerance_grad=0,
        tolerance_change=0,
    )

    def evaluate() -> torch.Tensor:
        nonlocal done
        done += 1
        total = learner.losses(c)[0]
        learner.vector.grad = learner.gradient
        return total

    while done < schedule.epochs:
        optimiser.step(evaluate)
        yield done


def library_soap(learner: Learner, schedule: Schedule, c: torch.Tensor) -> Iterator[int]:
    """SOAP of the package pytorch_optimizer, on the same loss and gradient."""
    from pytorch_optimizer import SOAP

    optimiser = SOAP(
        learner.parts,
        lr=schedule.learning_rate,
        betas=(0.9, 0.95),
        weight_decay=0.0,
        precondition_frequency=5,
    )
    for part, slope in zip(learner.parts, learner.slopes):
        part.grad = slope
    for step in range(schedule.epochs):
        learner.losses(c)
        for group in optimiser.param_groups:
            group["lr"] = schedule.rate_at(step, schedule.epochs)
        optimiser.step()
        yield step + 1


def curve(
    method: str, scene: str, changes: dict, steps: Steps = soap_or_adam, looks: int = LOOKS
) -> Curve:
    """Trains a few times, which is the same training each time; the first time it stops the clock
    and looks at the model on the way.
    """
    chosen, training, found = method_from_settings(method, changes), data(scene), Curve()
    marks = sorted({*np.geomspace(10, chosen.epochs, looks).round().astype(int).tolist()})
    clocks, making = [], []
    for turn in range(ROUNDS):
        ahead, clock, spent, began = list(marks), [], 0.0, time.process_time()
        problem, schedule = chosen.problem(training), chosen.plan()
        dtype = getattr(torch, schedule.precision)
        learner = Learner(
            problem.autoencoder,
            problem.dynamics,
            dtype,
            problem.device,
            torch.Generator().manual_seed(training.seed),
        )
        for done in steps(learner, schedule, torch.tensor(problem.train, dtype=dtype)):
            if done < ahead[0]:
                continue
            ahead = [mark for mark in ahead if mark > done]
            spent += time.process_time() - began
            clock.append(spent)
            if turn == 0:
                began = time.process_time()
                rom = chosen.model(training, problem, *learner.learnt())
                making.append(time.process_time() - began)
                judge(rom, method, scene, found)
            if not ahead:
                break
            began = time.process_time()
        clocks.append(clock)
    found.seconds = (np.median(clocks, axis=0) + np.median(making)).tolist()
    return found


def judge(rom: Rom, method: str, scene: str, found: Curve) -> None:
    found.reconstruction.append(reconstruction(rom, scene))
    found.decay.append(decay(rom, scene))
    if method == "split":
        plus = method_from_settings("split_plus", {})
        found.corrected.append(decay(plus.fit(replace(data(scene), start=rom)), scene))


@dataclass(frozen=True)
class Way:
    """Another way to train SPLIT: what changes in its settings, and who takes the steps."""

    name: str
    changes: dict
    steps: Steps = soap_or_adam


WAYS = (
    Way("Adam, one cycle", {"optimiser": "adam", "learning_rate": 4e-3, "epochs": 2000}),
    Way(
        "L-BFGS after 200 steps of Adam",
        {"optimiser": "adam", "learning_rate": 4e-3, "epochs": 1500},
        lbfgs,
    ),
    Way("SOAP of pytorch_optimizer", {}, library_soap),
    Way("every sample instead of every 10th", {"every": 1}),
    Way("every 20th sample", {"every": 20}),
    Way("all 240 displacements instead of 14 POD coordinates", {"rank": 0}),
    Way("float64 instead of float32", {"precision": "float64"}),
)
