"""Rollouts of reduced models against SciPy's solve_ivp.

Both integrate the folding scene's fitted models with the 8th-order method of Dormand and Prince,
with the tolerances of the main job: relative 1e-8, absolute 1e-10 of the training range. Rival B
calls the models' numpy functions, one run after the other; ours is compiled and takes eight runs
side by side on one core. Compilation is kept on disk and not counted, and neither is the rival's
first call.

The sweep has 33 frequencies from rest, 200 periods each, and shows the last one. The rival takes
every fourth frequency and its time is scaled by 33/9, since all of it would take minutes for each
model; our whole sweep is timed between any two of its runs. A model that blows up ends early for
both.

Two solutions may differ by the local tolerance times the steps that the motion remembers, more at a
fold of the response curve. So differences are told in units of the tolerance (1e-8 of the training
range) beside the rival's own distance from a solution a thousand times tighter. Work and precision
are those of a decay of 30 periods, errors being distances from a solution with a tolerance of 1e-13
over the training range. SSMLearn's models of higher order are fitted here and swept at a twentieth
of the forcing, which keeps them in their range and the work whole. "As four functions" is a model
without compiled code: the compiled loop then calls its numpy functions for eight runs at once.
"""

import json
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from statistics import median
from time import perf_counter

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from benchmarks.rivals.solve_ivp import simulate
from benchmarks.table import Row, paired
from vibrom.artefacts.data import open_dataset
from vibrom.methods.ssmlearn import SsmLearn
from vibrom.models.recorded import structure as operators
from vibrom.models.recorded import trajectory
from vibrom.models.rollout import LIMIT, Drive, Integrator, rollout
from vibrom.models.rom import Rom, rom_from_dataset
from vibrom.models.training import Training
from vibrom.report.drawing.style import look

SCENE = Path("results/folding")
DATA = {"structure": "structure", "train": "trajectory", "test": "trajectory", "frc": "frc"}
METHODS = (
    "modal_projection",
    "ssmlearn",
    "pysindy_modal",
    "split",
    "split_plus",
    "decoupled_autoencoder",
    "sindy_autoencoder",
)
SETTINGS, EVERY, SAMPLES = Integrator(), 4, 500
PRECISION = ("ssmlearn", "split")  # one of each form
TOLERANCES = [10.0**-k for k in range(3, 12)]
ORDERS = (3, 5, 7, 9, 11)


@dataclass(frozen=True)
class Sweep:
    """Forced runs from rest, one frequency each."""

    drive: Drive  # of 33 runs
    times: np.ndarray  # (33, SAMPLES) of the last period [s]

    def start(self, rom: Rom) -> np.ndarray:
        """The encoded state of rest (r,)."""
        return rom.encode(np.zeros((1, 2 * len(self.drive.load))))[0]

    def ours(self, rom: Rom, integrator: Integrator = SETTINGS) -> np.ndarray:
        """All runs (33, SAMPLES, r)."""
        start = np.repeat(self.start(rom)[None], len(self.times), axis=0)
        return rollout(rom, start, self.times, integrator, self.drive).reduced

    def theirs(self, rom: Rom, k: int) -> np.ndarray:
        """Run k (SAMPLES, r) by the rival."""
        settings = SETTINGS.rtol, SETTINGS.atol * rom.reach, LIMIT * rom.reach
        signal = self.drive.load, self.drive.amplitude[k], self.drive.frequency[k]
        return simulate(rom, self.start(rom), self.times[k], *settings, *signal)


@dataclass(frozen=True)
class FourFunctions(Rom):
    """A model without compiled code."""

    inner: Rom

    def encode(self, x):
        return self.inner.encode(x)

    def decode(self, z):
        return self.inner.decode(z)

    def drift(self, z):
        return self.inner.drift(z)

    def force_map(self, z, p):
        return self.inner.force_map(z, p)


def measure(note) -> Iterator[Row]:
    models = {
        method: next(iter(sorted(SCENE.glob(f"{method}/*/rom.nc"))), None) for method in METHODS
    }
    data = [SCENE / "full_order" / f"{name}.nc" for name in DATA]
    if not all(path.is_file() for path in data) or not all(models.values()):
        note(f"{SCENE} holds no models or no full-order data: run make first")
        return
    known, train, test, truth = map(open_dataset, data, DATA.values())
    frequency = truth["angular_frequency"].values
    period = (2 * np.pi / frequency)[:, None]
    drive = Drive(known["load"].values, np.full(len(frequency), float(truth["forcing"])), frequency)
    periods = json.loads(truth.attrs["settings"])["experiment"]["periods"]
    sweep = Sweep(drive, period * (periods - 1 + np.arange(SAMPLES) / SAMPLES))
    for method, path in models.items():
        rom = rom_from_dataset(open_dataset(path, "rom"))
        yield from _sweep(method, rom, sweep, note)
        tolerances = TOLERANCES if method in PRECISION else [SETTINGS.rtol]
        yield from _decay(method, rom, trajectory(test), tolerances, note)
        if method == PRECISION[0]:
            name, outside = f"{method} as four functions", FourFunctions(rom.reach, rom)
            yield from _sweep(name, outside, sweep, note, every=4 * EVERY)
    yield from _orders(Training((trajectory(train),), structure=operators(known)), sweep, note)


def _orders(training: Training, sweep: Sweep, note) -> Iterator[Row]:
    """SSMLearn's models of higher order, at a twentieth of the forcing."""
    note("orders of SSMLearn")
    gentle = replace(sweep, drive=replace(sweep.drive, amplitude=sweep.drive.amplitude / 20))
    roms = {order: SsmLearn(1, order, order).fit(training) for order in ORDERS}
    calls = {order: partial(gentle.ours, rom) for order, rom in roms.items()}
    for order, seconds in paired(calls, repeats=5).items():
        yield Row("rollouts", f"ssmlearn of order {order}: seconds of a gentle sweep", seconds, "s")


def _sweep(name: str, rom: Rom, sweep: Sweep, note, every: int = EVERY) -> Iterator[Row]:
    chosen = range(0, len(sweep.times), every)
    note(f"{name}: sweep, the rival {len(chosen)} of {len(sweep.times)} frequencies")
    tighter = replace(SETTINGS, rtol=SETTINGS.rtol / 1000, atol=SETTINGS.atol / 1000)
    mine, tight = sweep.ours(rom), sweep.ours(rom, tighter)
    rom.force_map(sweep.start(rom), sweep.drive.load)
    seconds, rival_seconds, apart, rival_apart, alike = [], 0.0, [], [], 0
    for k in chosen:
        began = perf_counter()
        sweep.ours(rom)
        middle = perf_counter()
        other = sweep.theirs(rom, k)
        seconds.append(middle - began)
        rival_seconds += perf_counter() - middle
        unit = SETTINGS.rtol * rom.reach
        apart.append(np.abs((mine[k] - other) / unit).max())  # NaN where a run ended early
        rival_apart.append(np.abs((tight[k] - other) / unit).max())
        alike += np.isfinite(mine[k, -1, 0]) == np.isfinite(other[-1, 0])
    rival_seconds *= len(sweep.times) / len(chosen)
    yield Row(
        "rollouts", f"{name}: seconds of a sweep", median(seconds), "s", "solve_ivp", rival_seconds
    )
    told = {"difference of both": apart, "error of the rival": rival_apart}
    for what, values in told.items() if np.isfinite(apart).any() else ():
        quantity = f"{name}: largest {what} in a sweep, in tolerances"
        yield Row("rollouts", quantity, np.nanmax(values), "1")
    yield Row(
        "rollouts", f"{name}: runs of {len(chosen)} that end alike in both", float(alike), "1"
    )


def _decay(method: str, rom: Rom, released, tolerances: list[float], note) -> Iterator[Row]:
    note(f"{method}: decay")
    start, times = rom.encode(released.state[0]), released.time - released.time[0]

    def theirs(rtol: float):
        return simulate(rom, start, times, rtol, rtol / 100 * rom.reach, LIMIT * rom.reach)

    def ours(rtol: float):
        return rollout(rom, start[None], times[None], Integrator(rtol, rtol / 100)).reduced[0]

    exact = theirs(1e-13) if len(tolerances) > 1 else None
    for rtol in tolerances:
        calls = {"ours": partial(ours, rtol), "rival": partial(theirs, rtol)}
        pairs = {"seconds": (paired(calls, repeats=5), "s")}
        if exact is not None:
            errors = {
                name: np.abs((call() - exact) / rom.reach).max() for name, call in calls.items()
            }
            pairs["error"] = errors, "1"
        for what, (found, unit) in pairs.items():
            quantity = f"{method}: {what} of a decay at {rtol:.0e}"
            yield Row("rollouts", quantity, found["ours"], unit, "solve_ivp", found["rival"])


def figures(rows: pd.DataFrame) -> dict[str, Figure]:
    """Work and precision of decays; seconds of the sweeps."""

    def column(text: str, name: str) -> pd.DataFrame:
        found = rows[rows["quantity"].str.startswith(f"{name}: {text}")]
        return found[["value", "rival_value"]].to_numpy(float)

    work = Figure(figsize=(7.0, 3.2))
    left, right = work.subplots(1, 2)
    for index, name in enumerate(PRECISION):
        seconds, errors = column("seconds of a decay", name), column("error of a decay", name)
        if len(seconds) == len(errors):
            left.loglog(seconds[:, 0], errors[:, 0], label=f"{name}, ours", **look(index))
            left.loglog(
                seconds[:, 1],
                errors[:, 1],
                label=f"{name}, solve_ivp",
                **look(index, linestyle=":", markerfacecolor=look(index)["color"]),
            )
    left.set(
        title="A decay of 30 periods", xlabel="seconds", ylabel="largest error / training range"
    )
    left.legend(loc="upper center", bbox_to_anchor=(0.5, -0.18), ncols=2)
    names = [name for name in METHODS if len(column("seconds of a sweep", name))]
    place, sweep = (
        np.arange(len(names)),
        np.array([column("seconds of a sweep", name)[0] for name in names]),
    )
    right.barh(place - 0.2, sweep[:, 1], 0.38, color="0.75", label="solve_ivp")
    right.barh(place + 0.2, sweep[:, 0], 0.38, color="#8a2a0b", label="ours")
    right.set(
        title="A sweep of 33 frequencies, 200 periods",
        xlabel="seconds",
        xscale="log",
        yticks=place,
        yticklabels=[name.replace("_", " ") for name in names],
    )
    right.legend(loc="upper center", bbox_to_anchor=(0.5, -0.18), ncols=2)
    return {"rollouts": work}
