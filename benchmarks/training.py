"""Training: seconds to accuracy.

What counts is not epochs per second but the time until a network predicts well. The clock covers
coordinates, training and making the model, from data in memory; importing, compiling and judging
are not in it. It counts processor time of one thread, which is what a wall clock shows on an idle
core. Models are judged on the test decay, which no training sees, by reconstruction (the model's
own coordinates) and by decay (released and left alone), both as NMTE. A bound counts as reached at
the first look from which on the error stays below it; a training is looked at 24 times, and clocked
three times.

Each method's default is timed on each scene until it is as good as the thesis's model, whose
training took 1.6 hours on another machine. Then SPLIT on the folding scene is trained in other ways
from the same seed on the same loss: other optimisers, samples, coordinates, precision. Adam and
L-BFGS have the steps and the rate that suited them best in trials, the others those of the default;
L-BFGS starts from 200 steps of Adam. All use the gradient of `vibrom.latent`; steps of L-BFGS are
evaluations of the loss.

Last comes the thesis's literal recipe (displacements, physical time, ELU, batches of 1024, Adam):
iterations per second by the wall clock, against the same written with torch's own modules,
forward-mode derivatives and automatic differentiation, and against what the thesis's table of run
times gives. Where there is a GPU, it then trains too.
"""

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path

import numpy as np
import pandas as pd
import torch
import yaml
from matplotlib.figure import Figure
from matplotlib.ticker import FormatStrFormatter, LogLocator, NullFormatter

from benchmarks.rivals import autograd_split
from benchmarks.table import NAN, Row, paired
from vibrom.artefacts.data import open_dataset
from vibrom.latent.optimisers import OPTIMISERS
from vibrom.latent.training import Learner, Schedule, epochs, warm_up
from vibrom.methods import method_from_settings
from vibrom.models.measures import nmte_percent
from vibrom.models.recorded import structure, trajectory
from vibrom.models.rollout import Integrator, decode_displacement, rollout
from vibrom.models.rom import Rom
from vibrom.models.training import Training, Trajectory
from vibrom.report.drawing.style import look
from vibrom.thesis.labels import LABELS
from vibrom.thesis.published import percent, run_time

SCENES = ("small", "large", "folding")
METHODS = ("decoupled_autoencoder", "sindy_autoencoder", "split")
LOOKS = 24  # at an error curve
ROUNDS = 3  # of each training; their median clock counts
BOUNDS = (0.25, 0.16)  # percent reconstruction, on the folding scene; the default ends near 0.15
BATCH, ITERATIONS = 1024, 40  # of the literal recipe
# 15 000 epochs of 29 996 samples in batches of 1000, in the seconds of the thesis's table of run
# times
THESIS_ITERATIONS = 15_000 * 30


@dataclass
class Curve:
    """Errors [%] and losses of one training at several looks; `seconds` are those to have that
    model.
    """

    seconds: list[float] = field(default_factory=list)
    reconstruction: list[float] = field(default_factory=list)
    decay: list[float] = field(default_factory=list)
    corrected: list[float] = field(default_factory=list)  # decay of SPLIT+ on the same networks

    def until(self, errors: list[float], bound: float) -> float:
        """Seconds from which on the error is below; NaN if it never stays so."""
        below = np.array(errors) <= bound
        last = len(below) - int(np.argmin(below[::-1])) if not below.all() else 0
        return self.seconds[last] if last < len(below) else NAN


CURVES: dict[str, dict[str, Curve]] = {}  # figure -> label -> curve, of the last `measure`


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


def settings(method: str) -> dict:
    return yaml.safe_load(Path(f"config/methods/{method}.yaml").read_text())["settings"]


def reconstruction(rom: Rom, scene: str) -> float:
    test = test_motion(scene)
    return nmte_percent(test.displacement, decode_displacement(rom, rom.encode(test.state)))


def decay(rom: Rom, scene: str) -> float:
    test = test_motion(scene)
    run = rollout(rom, rom.encode(test.state[:1]), (test.time - test.time[0])[None], Integrator())
    return nmte_percent(test.displacement, decode_displacement(rom, run.reduced[0]))


Steps = Callable[
    [Learner, Schedule, torch.Tensor], Iterator[int]
]  # trains, and yields the number of steps done


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
    chosen, training, found = (
        method_from_settings(method, settings(method) | changes),
        data(scene),
        Curve(),
    )
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
                rom = chosen.model(training, problem, learner.learnt())
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
        plus = method_from_settings("split_plus", settings("split_plus"))
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


def measure(note: Callable[[str], None]) -> Iterator[Row]:
    for path in (
        Path("results") / scene / "full_order" / f"{name}.nc"
        for scene in SCENES
        for name in ("train", "test", "structure")
    ):
        if not path.is_file():
            note(f"{path} is missing: run `make` first")
            return
    torch.set_num_threads(1)
    warm_up(torch.device("cpu"))
    decay(
        method_from_settings("split", settings("split") | {"epochs": 2}).fit(data("small")), "small"
    )  # compiles
    CURVES.clear()
    for scene in SCENES:
        for method in METHODS:
            note(f"{scene}: {method}")
            found = CURVES.setdefault(scene, {})[LABELS[method]] = curve(method, scene, {})
            yield from default_rows(scene, method, found)
    yield from other_rows(note)
    yield from literal_rows(note)
    yield from device_rows(note)


def default_rows(scene: str, method: str, found: Curve) -> Iterator[Row]:
    """Seconds to be as good as the thesis's model, and how good it is in the end; SPLIT+ is a
    regression on the networks of SPLIT.
    """
    name, published = f"{LABELS[method]}, {scene}", run_time("obtain_mapping_s", scene, method)
    thesis = "the thesis, its whole training (another machine)"
    for quantity, errors in (("reconstruction", found.reconstruction), ("decay", found.decay)):
        until = found.until(errors, percent(quantity, scene, method)[0])
        yield Row(
            "training",
            f"{name}: seconds until the thesis's {quantity}",
            until,
            "s",
            thesis,
            published,
        )
    yield Row("training", f"{name}: whole training", found.seconds[-1], "s", thesis, published)
    yield Row(
        "training",
        f"{name}: reconstruction",
        found.reconstruction[-1],
        "%",
        "the thesis",
        percent("reconstruction", scene, method)[0],
    )
    yield Row(
        "training",
        f"{name}: decay",
        found.decay[-1],
        "%",
        "the thesis",
        percent("decay", scene, method)[0],
    )
    if found.corrected:
        yield Row(
            "training",
            f"SPLIT+, {scene}: decay",
            found.corrected[-1],
            "%",
            "the thesis",
            percent("decay", scene, "split_plus")[0],
        )


def other_rows(note: Callable[[str], None]) -> Iterator[Row]:
    """The folding scene's SPLIT in other ways, beside the default."""
    note("folding: split, the default once more")
    default = curve("split", "folding", {})
    kept = CURVES["other ways"] = {"SOAP, every 10th sample, POD, float32": default}
    for way in WAYS:
        note(f"folding: split, {way.name}")
        try:
            other = kept[way.name] = curve("split", "folding", way.changes, way.steps)
        except ImportError as error:
            note(f"left out, {error.name} is not installed")
            continue
        for bound in BOUNDS:
            until, late = other.until(other.reconstruction, bound), ""
            if not np.isfinite(until):
                until, late = other.seconds[-1], " (not reached by its end)"
            yield Row(
                "training",
                f"SPLIT, folding: seconds until {bound} % reconstruction",
                default.until(default.reconstruction, bound),
                "s",
                way.name + late,
                until,
            )
        yield Row(
            "training",
            "SPLIT, folding: reconstruction in the end",
            default.reconstruction[-1],
            "%",
            way.name,
            other.reconstruction[-1],
        )
        yield Row(
            "training",
            "SPLIT, folding: decay in the end",
            default.decay[-1],
            "%",
            way.name,
            other.decay[-1],
        )


def literal_rows(note: Callable[[str], None]) -> Iterator[Row]:
    """The thesis's literal recipe: iterations per second."""
    note("the literal recipe")
    literal = yaml.safe_load(Path("config/thesis_literal.yaml").read_text())["method_settings"][
        "split"
    ]
    chosen = method_from_settings("split", settings("split") | literal)
    problem = chosen.problem(data("folding"))
    c = torch.tensor(
        problem.train[:, : BATCH * (problem.train.shape[1] // BATCH)], dtype=torch.float32
    )
    learner = Learner(
        problem.autoencoder,
        problem.dynamics,
        torch.float32,
        problem.device,
        torch.Generator().manual_seed(0),
    )
    rounds = replace(chosen.plan(), batch=BATCH, epochs=ITERATIONS * BATCH // c.shape[1])
    steps = rounds.epochs * c.shape[1] // BATCH
    torch.manual_seed(0)
    dynamics = problem.dynamics
    linear, powers = (
        torch.tensor(dynamics.linear, dtype=torch.float32),
        torch.tensor(dynamics.powers),
    )
    model = autograd_split.Split(c.shape[-1], linear, powers, dynamics.full, dynamics.reduced)

    def ours() -> None:
        for _ in epochs(learner, OPTIMISERS["adam"](learner.vector, learner.shapes), rounds, c):
            pass

    seconds = paired(
        {
            "ours": ours,
            "rival": lambda: autograd_split.iterations(
                model, c, BATCH, steps, chosen.learning_rate
            ),
        },
        repeats=5,
    )
    for rival, rate in (
        ("torch modules and automatic differentiation", steps / seconds["rival"]),
        (
            "the thesis (another machine)",
            THESIS_ITERATIONS / run_time("obtain_mapping_s", "folding", "split"),
        ),
    ):
        yield Row(
            "training",
            "literal recipe, SPLIT, folding: iterations per second",
            steps / seconds["ours"],
            "1/s",
            rival,
            rate,
            "higher",
        )


def device_rows(note: Callable[[str], None]) -> Iterator[Row]:
    """A whole training on a GPU, where there is one, and on a core of the processor, by the wall
    clock.
    """
    if not torch.cuda.is_available():
        note("no GPU on this machine")
        return
    for text, changes in (
        ("default", {}),
        ("every sample", {"every": 1}),
        ("every sample, all 240 displacements", {"every": 1, "rank": 0}),
    ):
        note(f"folding: split on a GPU, {text}")
        chosen = method_from_settings("split", settings("split") | changes)
        seconds = paired(
            {
                device: lambda device=device, chosen=chosen: chosen.fit(
                    replace(data("folding"), device=device)
                )
                for device in ("cuda", "cpu")
            },
            repeats=3,
        )
        yield Row(
            "training",
            f"SPLIT, folding, {text}: whole training on {torch.cuda.get_device_name()}",
            seconds["cuda"],
            "s",
            "one core",
            seconds["cpu"],
        )


def figures(rows: pd.DataFrame) -> dict[str, Figure]:
    """Error against seconds: the default of each method on each scene, and the other ways."""
    drawn = {}
    for name, curves in CURVES.items():
        figure = Figure(figsize=(7.0, 2.5 + 0.08 * len(curves)))
        axes = figure.subplots(1, 2)
        for axis, quantity in zip(axes, ("reconstruction", "decay")):
            for index, (label, found) in enumerate(curves.items()):
                axis.loglog(
                    found.seconds, getattr(found, quantity), **look(index, marker="", label=label)
                )
            scene = name if name in SCENES else "folding"
            for index, method in enumerate(METHODS if name in SCENES else ("split",)):
                thesis = (
                    {key: look(index)[key] for key in ("color", "linestyle")}
                    if name in SCENES
                    else {"color": "0.3"}
                )
                axis.axhline(percent(quantity, scene, method)[0], linewidth=0.6, **thesis)
            axis.set(
                title=f"{name}: {quantity} (thin: the thesis)",
                xlabel="seconds of training",
                ylabel="NMTE / %",
            )
            axis.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
            axis.xaxis.set_major_formatter(FormatStrFormatter("%g"))
            axis.xaxis.set_minor_formatter(NullFormatter())
        figure.legend(
            *axes[0].get_legend_handles_labels(),
            loc="outside lower center",
            ncols=3 if len(curves) == 3 else 2,
        )
        drawn[f"training_{name.replace(' ', '_')}"] = figure
    return drawn
