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
of the forcing, which keeps them in their range and the work whole.
"""

from collections.abc import Iterator
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
from vibrom.models.rom import rom_from_dataset
from vibrom.models.training import Training
from vibrom.report.drawing.style import look

SCENE = Path("results/folding")
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


def measure(note) -> Iterator[Row]:
    models = {
        method: next(iter(sorted(SCENE.glob(f"{method}/*/rom.nc"))), None) for method in METHODS
    }
    if not all(
        (SCENE / "full_order" / f"{name}.nc").is_file()
        for name in ("structure", "train", "test", "frc")
    ) or not all(models.values()):
        note(f"{SCENE} holds no models or no full-order data: run make first")
        return
    known, train, test, truth = (
        open_dataset(SCENE / "full_order" / f"{name}.nc", kind)
        for name, kind in (
            ("structure", "structure"),
            ("train", "trajectory"),
            ("test", "trajectory"),
            ("frc", "frc"),
        )
    )
    released, forcing, frequency = (
        trajectory(test),
        float(truth["forcing"]),
        truth["angular_frequency"].values,
    )
    drive = Drive(known["load"].values, np.full(len(frequency), forcing), frequency)
    last_period = (2 * np.pi / frequency)[:, None] * (
        truth.attrs["periods"] - 1 + np.arange(SAMPLES) / SAMPLES
    )
    for method, path in models.items():
        rom = rom_from_dataset(open_dataset(path, "rom"))
        yield from _sweep(method, rom, drive, last_period, note)
        yield from _decay(
            method, rom, released, TOLERANCES if method in PRECISION else [SETTINGS.rtol], note
        )
    training = Training((trajectory(train),), structure=operators(known))
    gentle = Drive(drive.load, drive.amplitude / 20, frequency)
    roms = {order: SsmLearn(1, order, order).fit(training) for order in ORDERS}
    note("orders of SSMLearn")
    seconds = paired(
        {
            order: lambda rom=rom: rollout(
                rom, np.zeros((len(frequency), 2)), last_period, SETTINGS, gentle
            )
            for order, rom in roms.items()
        },
        repeats=5,
    )
    for order, value in seconds.items():
        yield Row("rollouts", f"ssmlearn of order {order}: seconds of a gentle sweep", value, "s")


def _sweep(method: str, rom, drive: Drive, times: np.ndarray, note) -> Iterator[Row]:
    runs, start = len(drive.frequency), rom.encode(np.zeros((1, 2 * len(drive.load))))[0]
    chosen = range(0, runs, EVERY)
    note(f"{method}: sweep, the rival {len(chosen)} of {runs} frequencies")

    def ours(rtol=SETTINGS.rtol, atol=SETTINGS.atol):
        return rollout(
            rom, np.repeat(start[None], runs, axis=0), times, Integrator(rtol, atol), drive
        ).reduced

    def theirs(k: int):
        return simulate(
            rom,
            start,
            times[k],
            SETTINGS.rtol,
            SETTINGS.atol * rom.reach,
            LIMIT * rom.reach,
            drive.load,
            drive.amplitude[k],
            drive.frequency[k],
        )

    mine, tight = ours(), ours(SETTINGS.rtol / 1000, SETTINGS.atol / 1000)
    rom.force_map(start, drive.load)
    seconds, rival_seconds, apart, rival_apart, alike = [], 0.0, [], [], 0
    for k in chosen:
        began = perf_counter()
        ours()
        middle = perf_counter()
        other = theirs(k)
        seconds.append(middle - began)
        rival_seconds += perf_counter() - middle
        unit = SETTINGS.rtol * rom.reach
        apart.append(np.abs((mine[k] - other) / unit).max())  # NaN where a run ended early
        rival_apart.append(np.abs((tight[k] - other) / unit).max())
        alike += np.isfinite(mine[k, -1, 0]) == np.isfinite(other[-1, 0])
    yield Row(
        "rollouts",
        f"{method}: seconds of a sweep",
        median(seconds),
        "s",
        "solve_ivp",
        rival_seconds * runs / len(chosen),
    )
    if np.isfinite(apart).any():
        yield Row(
            "rollouts",
            f"{method}: largest difference of both in a sweep, in tolerances",
            np.nanmax(apart),
            "1",
        )
        yield Row(
            "rollouts",
            f"{method}: largest error of the rival in a sweep, in tolerances",
            np.nanmax(rival_apart),
            "1",
        )
    yield Row(
        "rollouts", f"{method}: runs of {len(chosen)} that end alike in both", float(alike), "1"
    )


def _decay(method: str, rom, released, tolerances: list[float], note) -> Iterator[Row]:
    note(f"{method}: decay")
    start, times = rom.encode(released.state[0]), released.time - released.time[0]

    def theirs(rtol: float):
        return simulate(rom, start, times, rtol, rtol / 100 * rom.reach, LIMIT * rom.reach)

    def ours(rtol: float):
        return rollout(rom, start[None], times[None], Integrator(rtol, rtol / 100)).reduced[0]

    exact = theirs(1e-13) if len(tolerances) > 1 else None
    for rtol in tolerances:
        seconds = paired({"ours": lambda: ours(rtol), "rival": lambda: theirs(rtol)}, repeats=5)
        yield Row(
            "rollouts",
            f"{method}: seconds of a decay at {rtol:.0e}",
            seconds["ours"],
            "s",
            "solve_ivp",
            seconds["rival"],
        )
        if exact is not None:
            error, other = (
                np.abs((found(rtol) - exact) / rom.reach).max() for found in (ours, theirs)
            )
            yield Row(
                "rollouts",
                f"{method}: error of a decay at {rtol:.0e}",
                error,
                "1",
                "solve_ivp",
                other,
            )


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
