"""Recorded motion, fitted models and their predictions in a few lines of Python:

recorded = vibrom.load(["first.csv", "second.csv"], time_unit="ms", length_unit="mm")
model = vibrom.fit(recorded, "ssmlearn", order_dynamics=5)
decay = model.predict(recorded.test[0])
driven = model.calibrated(frequency=770.0, amplitude=0.0165)
curve = driven.response(numpy.linspace(650.0, 800.0, 31))
model.save("beam.nc")
again = vibrom.open_model("beam.nc")
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NoReturn

import numpy as np

from vibrom.artefacts.data import DataError, label, open_dataset, save_dataset, variable
from vibrom.config import plugs
from vibrom.config.check import checked
from vibrom.config.errors import SettingsError, closest
from vibrom.config.recorded import METRES, SECONDS, Preparation
from vibrom.methods import method_from_settings
from vibrom.models.calibration import Calibration
from vibrom.models.measures import nmte_percent
from vibrom.models.model import Watch
from vibrom.models.reduced import Integrator, Reduced
from vibrom.models.rom import Rom, rom_from_dataset
from vibrom.models.training import Training, Trajectory
from vibrom.recordings import preparation, samples
from vibrom.recordings.start import described, recordings_in
from vibrom.solvers.periodic.carried import swept, swings


@dataclass(frozen=True)
class Recorded:
    """Decays as methods learn from them: see `vibrom.recordings.preparation`."""

    train: tuple[Trajectory, ...]  # displacement, velocity, acceleration (m, n) [m, s] of each
    test: tuple[Trajectory, ...]
    channels: tuple[str, ...]  # names (c,)
    places: np.ndarray  # (c,) of the channels themselves among the n displacements
    in_phase: np.ndarray  # (n,) what each displacement of a vibration is, over its channel
    frequency: float  # rad/s, of the highest line
    chosen: dict[str, float | str]  # what the rules of the preparation found


def load(
    files: Sequence[str | Path],
    *,
    time_unit: str = "s",
    length_unit: str = "m",
    step: float | None = None,
    **settings: Any,
) -> Recorded:
    """The motions in text, NumPy, MATLAB or netCDF files: the last one is for tests, or the one
    before it where the last swings farthest, and the others are for training; a single one is cut
    in the middle. `step`, in the unit of time, is that between samples of files without instants.
    `settings` are those of `vibrom.config.recorded.Preparation`: `start`, `filter`, `delays`, ...
    """
    for name, unit, known in (
        ("time_unit", time_unit, SECONDS),
        ("length_unit", length_unit, METRES),
    ):
        if unit not in known:
            _refuse((name,), unit, f"is not known; {closest(unit, known)}")
    found = [entry for path in files for entry in recordings_in(Path(path), step)]
    scene = described(found, time_unit, length_unit)
    return of_samples(samples.load(scene), **settings)


def of_arrays(
    time: np.ndarray, train: Sequence[np.ndarray], test: Sequence[np.ndarray], **settings: Any
) -> Recorded:
    """Motions (m, c) or (m,) [m] that were all recorded at the instants `time` (m,) [s]."""
    found = []
    for role, motions in (("train", train), ("test", test)):
        for number, motion in enumerate(motions):
            values = np.reshape(np.asarray(motion, float), (len(time), -1))
            names = tuple(f"channel_{k + 1}" for k in range(values.shape[1]))
            where = f"{role}[{number}]"
            found.append(samples.Samples(where, role, np.asarray(time, float), values, names))
    return of_samples(found, **settings)


def of_samples(found: list[samples.Samples], **settings: Any) -> Recorded:
    """Prepared with these settings."""
    kind = plugs.declared("vibrom.config.recorded", "Preparation")
    chosen = Preparation.from_builtins(checked(settings, kind, (), _refuse))
    decays = preparation.prepare(found, chosen)
    train, test = (tuple(item.motion for item in decays.of(role)) for role in ("train", "test"))
    phases = np.tile(decays.in_phase, len(decays.names))
    frequency = 2.0 * np.pi * decays.frequency
    return Recorded(train, test, decays.names, decays.probes, phases, frequency, decays.chosen)


def _refuse(path: tuple, value: Any, cure: str) -> NoReturn:
    raise SettingsError("settings", path, value, cure)


@dataclass(frozen=True)
class FittedModel:
    """A reduced model of recorded motion."""

    reduced: Reduced
    channels: tuple[str, ...]  # names (c,)

    @property
    def rom(self) -> Rom:
        """Encoder, decoder and dynamics."""
        return self.reduced.rom

    @property
    def eigenvalues(self) -> np.ndarray:
        """Of small motions about rest [1/s]."""
        return self.reduced.eigenvalues()

    def predict(self, motion: Trajectory) -> np.ndarray:
        """The channels (m, c) [m] at the instants of a recorded motion, from its first state."""
        watch = Watch(motion.time - motion.time[0], self.reduced.probes)
        return self.reduced.motion(motion.state[:1], None, watch).displacement[0][0]

    def error(self, motion: Trajectory) -> float:
        """NMTE of the prediction [%]: the mean distance over the largest displacement."""
        return nmte_percent(motion.displacement[:, self.reduced.probes], self.predict(motion))

    def calibrated(self, frequency: float, amplitude: float, channel: int = 0) -> FittedModel:
        """The same, driven so strongly that this channel swings by `amplitude` [m] to both sides
        under a load of this frequency [rad/s]. All channels are driven alike.
        """
        point = Calibration(frequency, amplitude, int(self.reduced.probes[channel]))
        return replace(self, reduced=replace(self.reduced, calibration=point))

    def response(
        self, frequency: np.ndarray, strength: float = 1.0, periods: int = 200
    ) -> np.ndarray:
        """Half the range (k, c) [m] of the channels at frequencies (k,) [rad/s] of the load, the
        motion carried on from one to the next; NaN from where it does not last. `strength` is in
        units of the calibrated load, else of an acceleration of 1 m/s2.
        """
        flow, frequency = self.reduced.return_map(), np.asarray(frequency, float)
        points = swept(flow, frequency, strength, periods)
        return 0.5 * np.ptp(swings(flow, points, frequency, strength), axis=-1)

    def save(self, path: str | Path) -> None:
        """Write the model as netCDF, all or nothing."""
        scene = self.reduced
        dataset = scene.rom.to_dataset().assign(
            scene_load=variable("dof", scene.known_load, "m s-2", "load per unit of the signal"),
            scene_probe_dof=variable("probe", scene.probes, "1", "displacement of each channel"),
            scene_frequency=variable((), scene.frequency, "rad s-1", "first frequency"),
            outcome=variable((), "ok", "1", "how the fit ended"),
        )
        names = variable("probe", np.array(self.channels, object), "1", "name of the channel")
        dataset = dataset.assign_coords(probe=names)
        save_dataset(label(dataset, "rom", scene="recorded", method=type(scene.rom).__name__), path)


def fit(
    recorded: Recorded, method: str = "ssmlearn", *, seed: int | None = None, **settings: Any
) -> FittedModel:
    """A model that a method of `src/vibrom/methods` learns from the training motions; `settings`
    are its fields. Methods that draw random numbers take a seed.
    """
    if method not in plugs.names("methods"):
        _refuse(("method",), method, f"is not known; {closest(method, plugs.names('methods'))}")
    asked = checked(settings, plugs.settings_of("methods", method), (), _refuse)
    chosen = method_from_settings(method, asked)
    rom = chosen.learn(Training(recorded.train, seed=seed))
    reduced = Reduced(rom, recorded.in_phase, recorded.places, recorded.frequency, Integrator())
    return FittedModel(reduced, recorded.channels)


def open_model(path: str | Path) -> FittedModel:
    """What `FittedModel.save` wrote."""
    try:
        stored = open_dataset(path, "rom")
        load, probes = (stored[f"scene_{name}"].values for name in ("load", "probe_dof"))
    except (DataError, KeyError) as error:
        raise DataError(
            f"{path}: no model that FittedModel.save wrote; give the path of one"
        ) from error
    reduced = Reduced(
        rom_from_dataset(stored), load, probes, float(stored["scene_frequency"]), Integrator()
    )
    return FittedModel(reduced, tuple(map(str, stored["probe"].values)))
