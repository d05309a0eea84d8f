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

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import torch
import yaml
from matplotlib.figure import Figure
from matplotlib.ticker import FormatStrFormatter, LogLocator, NullFormatter

from benchmarks.rivals import autograd_split
from benchmarks.table import Row, paired
from benchmarks.training_curve import WAYS, Curve, curve, data, decay
from vibrom.latent.learner import Learner
from vibrom.latent.optimisers import OPTIMISERS
from vibrom.latent.training import epochs, warm_up
from vibrom.methods import method_from_settings
from vibrom.report.drawing.style import look
from vibrom.thesis.labels import LABELS
from vibrom.thesis.published import percent, run_time

SCENES = ("small", "large", "folding")
METHODS = ("decoupled_autoencoder", "sindy_autoencoder", "split")
BOUNDS = (0.25, 0.16)  # percent reconstruction, on the folding scene; the default ends near 0.15
BATCH, ITERATIONS = 1024, 40  # of the literal recipe
# 15 000 epochs of 29 996 samples in batches of 1000, in the seconds of the thesis's table of run
# times
THESIS_ITERATIONS = 15_000 * 30


CURVES: dict[str, dict[str, Curve]] = {}  # figure -> label -> curve, of the last `measure`


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
    decay(method_from_settings("split", {"epochs": 2}).fit(data("small")), "small")  # compiles
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
    chosen = method_from_settings("split", literal)
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
        chosen = method_from_settings("split", changes)
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
