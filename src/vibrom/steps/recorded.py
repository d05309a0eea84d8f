"""Files of recorded motion -> structure.nc, train.nc, test.nc: what the full-order model of other
scenes makes.

The structure holds the linear part, from known operators or from the data, and what is known of the
load. Several recordings of one role follow one another in time, each with a number, `part`.
"""

from __future__ import annotations

import time as clock
from typing import Any

import numpy as np
import xarray as xr
from scipy.sparse import coo_matrix

from vibrom.artefacts.data import label, outcome_variables, save_dataset, variable
from vibrom.artefacts.outcome import Outcome
from vibrom.config.places import FULL_ORDER
from vibrom.config.recorded import METRES, UNDER_A_SIGNAL, Forcing, RecordedScene
from vibrom.recordings import samples
from vibrom.recordings.forced import PAUSE, Forced, forced_variables, prepare_forced
from vibrom.recordings.linear import linear_part
from vibrom.recordings.operators import known
from vibrom.recordings.preparation import Decays, Prepared, prepare
from vibrom.recordings.response import point, response

Variables = dict[str, xr.Variable]


def run(
    *,
    structure: str,
    train: str,
    test: str,
    scene: dict[str, Any],
    provenance: dict[str, str],
    files: list[str],
) -> None:
    """`files` are those that the scene names."""
    given, began = RecordedScene.from_builtins(scene), clock.perf_counter()
    under, alone = [], []
    for item in samples.load(given):
        (under if item.role in UNDER_A_SIGNAL else alone).append(item)
    decays = prepare(alone, given.preparation, 1 if given.operators else 0)
    forced = prepare_forced(under, decays, given.preparation)
    seconds = clock.perf_counter() - began
    for item in (*decays.prepared, *forced):
        print(f"{item.where}: {'; '.join(item.notes)}")
    made = {structure: structure_of(given, decays, forced)}
    for role, path in (("train", train), ("test", test)):
        made[path] = record(given, decays, role, seconds)
    for path, dataset in made.items():
        save_dataset(dataset, path, provenance)


def structure_of(scene: RecordedScene, decays: Decays, forced: tuple[Forced, ...]) -> xr.Dataset:
    """Linear part, probes, load, and motions under a signal."""
    variables, load = linear_variables(scene, decays), load_of(scene, decays, forced)
    unit, in_phase = "N" if scene.operators else "m s-2", np.outer(load, decays.in_phase).ravel()
    variables |= {
        "load": variable("dof", in_phase, unit, "load per unit of the signal"),
        "probe_dof": variable(
            "probe", decays.probes, "1", "free displacement that each probe watches"
        ),
    }
    if forced:
        variables |= forced_variables(forced, load, unit, len(decays.in_phase))
    if scene.forcing and scene.forcing.response:
        variables |= response_of(
            scene.forcing, decays, METRES[scene.length_unit], any_calibrates(forced)
        )
    coords = {
        "probe": probes(decays),
        "mode": variable(
            "mode", np.arange(1, len(variables["frequency"]) + 1), "1", "number of the mode"
        ),
    }
    return label(
        xr.Dataset(variables, coords),
        "structure",
        scene=scene.name,
        method=FULL_ORDER,
        scene_kind=scene.kind,
        preparation={key: str(value) for key, value in decays.chosen.items()},
    )


def probes(decays: Decays) -> xr.Variable:
    """The channels."""
    return variable("probe", np.array(decays.names, dtype=object), "1", "name of the channel")


def linear_variables(scene: RecordedScene, decays: Decays) -> Variables:
    """Modes with frequencies and damping ratios; operators, where they are known."""
    if scene.operators is None:
        found = linear_part([item.motion for item in decays.of("train")])
        shapes, frequency, ratio = found.shape[None], [found.frequency], [found.damping_ratio]
        units, words, matrices = "1", "first proper orthogonal direction", {}
    else:
        given = known(scene.operators, len(decays.names), decays.frequency)
        shapes, frequency = given.modes, given.frequencies
        ratio = np.einsum("ki,ij,kj->k", shapes, given.damping, shapes) / (2 * frequency)
        units, words = "kg^(-1/2)", "mass-normalised eigenmodes of the undamped linear body"
        matrices = {"mass": "kg", "damping": "kg s-1", "stiffness": "N m-1"}
    variables = {
        "mode_shape": variable(("mode", "dof"), shapes, units, words),
        "frequency": variable("mode", frequency, "rad s-1", "undamped angular eigenfrequencies"),
        "damping_ratio": variable("mode", ratio, "1", "damping ratio of each mode"),
    }
    for what, unit in matrices.items():
        variables |= entries(getattr(given, what), what, unit)
    return variables


def entries(matrix: np.ndarray, what: str, units: str) -> Variables:
    """A matrix by row, column and value of its entries."""
    found, dim = coo_matrix(matrix), f"{what}_entry"
    about = f"of each entry of the {what} matrix"
    return {
        f"{what}_row": variable(dim, found.row, "1", f"row {about}"),
        f"{what}_column": variable(dim, found.col, "1", f"column {about}"),
        f"{what}_value": variable(dim, found.data, units, f"entries of the {what} matrix"),
    }


def response_of(forcing: Forcing, decays: Decays, metres: float, calibrated: bool) -> Variables:
    """The measured response curve, and its point that tells how strong a load is that is neither
    known nor calibrated by a recording.
    """
    frequency, amplitude, channel, numbers = response(forcing.response, decays.names, metres)
    variables = {
        "response_frequency": variable("response", frequency, "rad s-1", "frequency of the load"),
        "response_amplitude": variable("response", amplitude, "m", "measured amplitude"),
        "response_dof": variable((), decays.probes[channel], "1", "displacement of the amplitude"),
    }
    if forcing.load is None and not calibrated:
        at = point(forcing.calibrate, amplitude, numbers, forcing.response.file)
        variables["calibration_point"] = variable(
            (), at, "1", "point that tells the strength of the load, from zero"
        )
    return variables


def any_calibrates(forced: tuple[Forced, ...]) -> bool:
    """Does one of these recordings tell the strength of the load?"""
    return any(item.role == "calibration" for item in forced)


def load_of(scene: RecordedScene, decays: Decays, forced: tuple[Forced, ...]) -> np.ndarray:
    """(c,) of the channels, per unit of the signal; NaN where nothing is known of the load."""
    count, given = len(decays.names), scene.forcing.load if scene.forcing else None
    calibrated = any_calibrates(forced)
    if given is None:
        return np.full(count, 1.0 if scene.forcing or calibrated else np.nan)
    if calibrated:
        raise samples.DataError(
            "forcing.load is given, and a recording has the role calibration; remove the load, or "
            "give the recording the role forced"
        )
    if len(given) != count:
        raise samples.DataError(f"forcing.load has {len(given)} entries for {count} channels")
    return np.array(given)


def record(scene: RecordedScene, decays: Decays, role: str, seconds: float) -> xr.Dataset:
    """The recordings of a role, one after the other."""
    items = decays.of(role)
    if not items:
        raise samples.DataError(f"scene {scene.name}: no recording has the role {role}; give one")
    time, first = [], 0.0
    for item in items:
        own = item.motion.time - item.motion.time[0]
        time.append(first + own)
        first += own[-1] + PAUSE * own[1]
    dims = ("time", "dof")
    q, v, a = (
        np.concatenate([getattr(item.motion, name) for item in items])
        for name in ("displacement", "velocity", "acceleration")
    )
    part = np.repeat(np.arange(len(items)), [len(item.motion.time) for item in items])
    dataset = xr.Dataset(
        {
            "displacement": variable(dims, q, "m", "displacement of each channel, delayed"),
            "velocity": variable(dims, v, "m s-1", "velocity of each channel, delayed"),
            "acceleration": variable(dims, a, "m s-2", "acceleration of each channel, delayed"),
            "probe_displacement": variable(
                ("probe", "time"), q[:, decays.probes].T, "m", "displacement of each channel"
            ),
            "part": variable("time", part, "1", "number of the recording, from zero"),
            "period": variable((), 1.0 / decays.frequency, "s", "period of the first line"),
            **slow_variables(items),
            **outcome_variables(Outcome.OK, seconds=seconds),
        },
        coords={
            "time": variable(
                "time", np.concatenate(time), "s", "time since the slow motion of the first began"
            ),
            "probe": probes(decays),
        },
    )
    return label(
        dataset,
        "trajectory",
        scene=scene.name,
        method=FULL_ORDER,
        role=role,
        recordings=[item.where for item in items],
        notes=["; ".join(item.notes) for item in items],
    )


def slow_variables(items: list[Prepared]) -> Variables:
    """The share of fast motion, on which the rule of the start is founded."""
    longest = max(len(item.slow.share) for item in items)
    padded = np.full((2, len(items), longest), np.nan)
    for row, item in enumerate(items):
        padded[:, row, : len(item.slow.share)] = item.slow.instant, item.slow.share
    dims = ("recording", "window")
    return {
        "window_instant": variable(dims, padded[0], "s", "beginning of each period"),
        "fast_share": variable(
            dims, padded[1], "1", "share of the acceleration's power that the slow dynamics leave"
        ),
        "fast_limit": variable(
            "recording", [item.slow.limit for item in items], "1", "limit of the share"
        ),
        "slow_begin": variable(
            "recording",
            [item.slow.begin for item in items],
            "s",
            "where the share first is within the limit",
        ),
    }
