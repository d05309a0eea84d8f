"""A small, consistent results folder: a beam of a few elements, models whose errors are chosen, one
that fails.

Every number that a test compares with is written here: `NMTE` for the scores, `omega` = 400 rad/s
for the frequencies.
"""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from vibrom import experiments
from vibrom.artefacts.data import label, outcome_variables, save_dataset, variable
from vibrom.artefacts.data import scored as scored_in
from vibrom.steps.experiment import nothing

PROVENANCE = {"source_digest": "0123456789abcdef", "versions": json.dumps({"numpy": "2.0"})}
PROBES = ("probe", "tip")
OMEGA, PERIOD = 400.0, 2 * np.pi / 400.0
FORCING = {"small": 1.0, "large": 600.0, "folding": 6000.0}
SIZE = {"small": 0.05, "large": 0.14, "folding": 0.36}
RUN_TIMES = (
    "generate_training_data_s",
    "obtain_mapping_s",
    "obtain_dynamics_s",
    "decay_s",
    "forced_s",
    "frc_s",
)


def scored(dataset, scores):
    """`dataset` with scores given as name -> (value, unit)."""
    return scored_in(
        dataset,
        {name: value for name, (value, _) in scores.items()},
        {name: unit for name, (_, unit) in scores.items()},
    )


class Tree:
    """results/ with these scenes, `methods` (name -> seeds, None = unseeded), errors `nmte[scene,
    method, seed]`, and failures: a set of (scene, method, seed) whose forced run diverges after
    three periods; `unfit`: those whose training diverged."""

    def __init__(
        self,
        root: Path,
        scenes,
        methods,
        nmte,
        failures=(),
        unfit=(),
        cells=(8, 2),
        periods=6,
        steps=40,
    ):
        self.root, self.scenes, self.methods = Path(root), list(scenes), methods
        self.nmte, self.failures, self.unfit = nmte, set(failures), set(unfit)
        self.cells, self.periods, self.steps = cells, periods, steps
        self.artefacts: list[str] = []
        self.rows: list[tuple] = []
        for scene in self.scenes:
            self.full_order(scene)
            for method, seeds in methods.items():
                for seed in seeds or [None]:
                    self.model(scene, method, seed)
        self.scores = str(self.root / "scores.csv")
        columns = [
            "scene",
            "method",
            "seed",
            "experiment",
            "metric",
            "value",
            "unit",
            "seconds",
            "outcome",
        ]
        pd.DataFrame(self.rows, columns=columns).to_csv(self.scores, index=False)

    def save(self, dataset, kind, scene, model, name, seed=None, **attributes):
        folder = self.root / scene / model
        folder = (
            folder
            if model == "full_order"
            else folder / ("unseeded" if seed is None else f"seed_{seed}")
        )
        labelled = label(dataset, kind, scene=scene, method=model, seed=seed, **attributes)
        save_dataset(labelled, folder / f"{name}.nc", PROVENANCE)
        self.artefacts.append(str(folder / f"{name}.nc"))

    def mesh(self):
        columns, rows = self.cells
        x, y = np.meshgrid(
            np.linspace(0, 1, columns + 1), np.linspace(0, 0.02, rows + 1), indexing="ij"
        )
        node = np.column_stack([x.ravel(), y.ravel()])
        at = np.arange(len(node)).reshape(columns + 1, rows + 1)
        element = np.stack([at[:-1, :-1], at[1:, :-1], at[1:, 1:], at[:-1, 1:]], axis=-1).reshape(
            -1, 4
        )
        free = np.flatnonzero(node[:, 0] > 0)
        return node, element, np.repeat(free, 2), np.tile([0, 1], len(free))

    def shape(self, size):
        """Displacement of the free dofs of a beam bent into an arc, its end about `size` [m] times
        2.7 up.
        """
        node, _, dof_node, dof_axis = self.mesh()
        angle = max(2.2 * size * 2.7, 1e-9)
        s, height = node[:, 0], node[:, 1] - 0.01
        moved = np.column_stack(
            [
                np.sin(angle * s) / angle - height * np.sin(angle * s),
                0.01 + (1 - np.cos(angle * s)) / angle + height * np.cos(angle * s),
            ]
        )
        return (moved - node)[dof_node, dof_axis]

    def probe_dofs(self):
        node, _, dof_node, dof_axis = self.mesh()
        places = [np.argmin(np.hypot(*(node - at).T)) for at in ([0.525, 0.0], [1.0, 0.0])]
        return [int(np.flatnonzero((dof_node == place) & (dof_axis == 1))[0]) for place in places]

    def full_order(self, scene):
        node, element, dof_node, dof_axis = self.mesh()
        n, probe = len(dof_node), ("probe", np.array(PROBES, dtype=object))
        units = {"units": "1", "long_name": "probe"}
        scene_blocks = {
            "body": {
                "length": 1.0,
                "height": 0.02,
                "width": 0.05,
                "cells": list(self.cells),
                "element": "bilinear",
            },
            "effects": {
                "inertia": {"density": 440.0},
                "elasticity": {"young_modulus": 104.0e9, "poisson_ratio": 0.3},
            },
        }
        self.save(
            xr.Dataset(
                {
                    "node": variable(("node", "axis"), node, "m", "coordinates"),
                    "element_node": variable(
                        ("element", "corner"), element, "1", "nodes of each element"
                    ),
                    "dof_node": variable("dof", dof_node, "1", "node"),
                    "dof_axis": variable("dof", dof_axis, "1", "axis"),
                    "mode_shape": variable(
                        ("mode", "dof"), np.zeros((4, n)), "kg^-0.5", "mode shapes"
                    ),
                    "frequency": variable(
                        "mode", OMEGA * np.array([1.0, 6.0, 17.0, 34.0]), "rad/s", "frequencies"
                    ),
                    "damping_ratio": variable("mode", np.full(4, 0.01), "1", "damping ratios"),
                    "load": variable("dof", np.zeros(n), "N", "load"),
                    "probe_dof": variable("probe", self.probe_dofs(), "1", "dof of each probe"),
                },
                coords={"probe": (*probe, units)},
            ),
            "structure",
            scene,
            "full_order",
            "structure",
            **scene_blocks,
        )
        states = np.stack([self.shape(SIZE[scene] * 1.1), self.shape(SIZE[scene])])
        self.save(
            xr.Dataset(
                {"displacement": variable(("role", "dof"), states, "m", "release states")},
                coords={
                    "role": variable("role", np.array(["train", "test"], dtype=object), "1", "role")
                },
            ),
            "release",
            scene,
            "full_order",
            "release",
        )
        time = np.arange(self.periods * self.steps + 1) * PERIOD / self.steps
        for role, size in (("train", 1.1), ("test", 1.0)):
            probes = self.decay_at_probes(scene, time) * size
            empty = np.zeros((len(time), n))
            self.save(
                xr.Dataset(
                    {
                        **{
                            name: variable(("time", "dof"), empty, unit, name)
                            for name, unit in (
                                ("displacement", "m"),
                                ("velocity", "m/s"),
                                ("acceleration", "m/s2"),
                            )
                        },
                        "probe_displacement": variable(
                            ("probe", "time"), probes, "m", "displacement at the probes"
                        ),
                        **outcome_variables("ok", seconds=2.0),
                    },
                    coords={"time": variable("time", time, "s", "time"), "probe": (*probe, units)},
                ),
                "trajectory",
                scene,
                "full_order",
                role,
            )
        self.forced_run(scene, "full_order", None, 1.0, "ok")
        self.curve(scene, "full_order", None, 1.0, False)
        self.worth(scene)
        self.save(self.backbone(scene, 1.0), "backbone", scene, "full_order", "backbone")
        self.save(self.pair(-4.0, OMEGA), "eigenvalues", scene, "full_order", "eigenvalues")
        pair = {"real_per_s": (-4.0, "1/s"), "imaginary_rad_per_s": (OMEGA, "rad/s")}
        self.score(scene, "full_order", None, "eigenvalues", pair)
        times = {"decay_s": (2.0, "s"), "forced_s": (13.0, "s"), "frc_s": (400.0, "s")}
        self.save(
            scored(xr.Dataset(outcome_variables("ok")), times),
            "run_times",
            scene,
            "full_order",
            "run_times",
        )
        self.score(scene, "full_order", None, "run_times", times)

    def worth(self, scene):
        """Without damping nothing decays, and a step costs half; elasticity cannot be left out, and
        without its stop the body fails.
        """
        time, last = np.arange(0, 6 * PERIOD, PERIOD / 20), np.arange(21) * PERIOD / 20
        left_out = np.array(["nothing", "elasticity", "rayleigh_damping", "stop"], dtype=object)
        known = np.array([1.0, np.nan, 1.0, np.nan])
        amplitude = SIZE[scene] * np.array([0.5, np.nan, 0.75, np.nan])
        decay = (
            SIZE[scene]
            * np.array([1.0, 2.7])[:, None]
            * np.cos(OMEGA * time)
            * np.exp(-np.array([30, 30, 0, 30])[:, None, None] * time)
        )
        at = ("left_out", "probe")
        self.save(
            xr.Dataset(
                {
                    "first_frequency": variable("left_out", OMEGA * known, "rad/s", "frequency"),
                    "decay_nmte": variable(
                        "left_out", [0.0, np.nan, 16.0, np.nan], "percent", "NMTE"
                    ),
                    "decay_frequency": variable(
                        at, np.outer(OMEGA * known, [1, 1]), "rad/s", "frequency"
                    ),
                    "decay_amplitude": variable(
                        at, np.outer(amplitude, [1, 2.7]), "m", "amplitude"
                    ),
                    "forced_amplitude": variable(
                        at, np.outer(amplitude, [1, 2.7]), "m", "amplitude"
                    ),
                    "decay_displacement": variable(
                        (*at, "time"), decay * known[:, None, None], "m", "decay"
                    ),
                    "forced_displacement": variable(
                        (*at, "last_time"),
                        np.einsum("i,j,k->ijk", amplitude, [1, 2.7], np.sin(OMEGA * last)),
                        "m",
                        "forced",
                    ),
                    "iterations_per_step": variable("left_out", 2 * known, "1", "iterations"),
                    "seconds_per_step": variable(
                        "left_out", 2e-5 * known * [1, 1, 0.5, 1], "s", "wall time"
                    ),
                    "seconds_ratio": variable("left_out", known * [1, 1, 2, 1], "1", "ratio"),
                    "outcome": variable(
                        "left_out",
                        np.array(
                            ["ok", "needed_by modal_load", "ok", "no_convergence"], dtype=object
                        ),
                        "1",
                        "outcome",
                    ),
                    "failed_at": variable(
                        "left_out", [np.nan, np.nan, np.nan, 0.01], "s", "failure"
                    ),
                },
                coords={
                    "left_out": variable("left_out", left_out, "1", "effect"),
                    "time": variable("time", time, "s", "time"),
                    "last_time": variable("last_time", last, "s", "time"),
                    "probe": variable("probe", np.array(PROBES, dtype=object), "1", "probe"),
                },
            ),
            "effects",
            scene,
            "full_order",
            "effects",
        )

    def decay_at_probes(self, scene, time):
        return (
            SIZE[scene] * np.array([1.0, 2.7])[:, None] * np.exp(-4 * time) * np.cos(OMEGA * time)
        )

    def backbone(self, scene, factor):
        amplitude = SIZE[scene] * np.linspace(1, 0.3, 9)
        frequency = factor * (OMEGA + 40 * amplitude**2)
        return xr.Dataset(
            {
                "amplitude": variable(
                    ("probe", "peak"), np.stack([amplitude, 2.7 * amplitude]), "m", "amplitude"
                ),
                "angular_frequency": variable(
                    ("probe", "peak"), np.stack([frequency] * 2), "rad/s", "angular frequency"
                ),
                "damping_ratio": variable(
                    ("probe", "peak"), np.full((2, 9), 0.01), "1", "damping ratio"
                ),
            },
            coords={"probe": variable("probe", np.array(PROBES, dtype=object), "1", "probe")},
        )

    def pair(self, real, imaginary):
        return scored(
            xr.Dataset(
                {
                    "real": variable("eigenvalue", [real, real], "1/s", "real part"),
                    "imaginary": variable(
                        "eigenvalue", [imaginary, -imaginary], "rad/s", "imaginary part"
                    ),
                }
            ),
            {"real_per_s": (real, "1/s"), "imaginary_rad_per_s": (imaginary, "rad/s")},
        )

    def forced_run(self, scene, model, seed, factor, outcome):
        time = np.arange(2 * self.periods * self.steps + 1) * PERIOD / self.steps
        peak = SIZE[scene] * FORCING[scene] ** 0.25
        probe = factor * peak * (1 - np.exp(-30 * time)) * np.sin(OMEGA * time)
        failed_at = np.nan
        if outcome == "diverged":
            failed_at = 3 * PERIOD
            growth = 1 + np.exp(np.minimum(900 * (time - 2.7 * PERIOD), 4.0))
            probe = np.where(time < failed_at, probe * growth, np.nan)
        last = time[-self.steps :]
        probes = variable(
            ("probe", "time"), np.stack([probe, 2.7 * probe]), "m", "displacement at the probes"
        )
        common = {"probe_displacement": probes, **outcome_variables(outcome, failed_at, 1.0)}
        coords = {
            "time": variable("time", time, "s", "time"),
            "last_time": variable("last_time", last, "s", "time"),
            "probe": variable("probe", np.array(PROBES, dtype=object), "1", "probe"),
        }
        true = self.shape(peak if peak < 0.5 else 0.5)
        if model == "full_order":
            scalars = {
                "forcing": (FORCING[scene], "1"),
                "angular_frequency": (OMEGA, "rad/s"),
                "period": (PERIOD, "s"),
            }
            states = np.outer(np.sin(OMEGA * last), true)
            self.save(
                xr.Dataset(
                    {
                        **common,
                        "last_displacement": variable(
                            ("last_time", "dof"), states, "m", "states of the last period"
                        ),
                        **{
                            name: variable((), value, unit, name)
                            for name, (value, unit) in scalars.items()
                        },
                    },
                    coords=coords,
                ),
                "forced",
                scene,
                model,
                "forced",
            )
            return
        shape = (
            self.shape(factor * min(peak, 0.5))
            if outcome != "diverged"
            else np.full_like(true, np.nan)
        )
        error = np.nan if outcome == "diverged" else 100 * abs(factor - 1)
        dataset = xr.Dataset(
            {
                **common,
                "final_shape": variable("dof", shape, "m", "shape"),
                "final_shape_true": variable("dof", true, "m", "shape of the full order"),
            },
            coords=coords,
        )
        scores = {"nmte_percent": (error, "percent"), "amplitude_error_percent": (error, "percent")}
        self.save(scored(dataset, scores), "forced", scene, model, "forced", seed)
        self.score(scene, model, seed, "forced", scores, outcome)

    def curve(self, scene, model, seed, factor, fails):
        ratio = np.linspace(0.8, 1.2, 9)
        answer = factor / (1 - ratio**2 + 0.05j * ratio)
        lost = fails & (np.abs(ratio - 1) < 0.06)
        amplitude = np.where(lost, np.nan, SIZE[scene] * np.abs(answer) / 10)
        phase = np.where(lost, np.nan, np.angle(answer))
        self.save(
            xr.Dataset(
                {
                    "amplitude": variable(
                        ("probe", "angular_frequency"),
                        np.outer([1, 2.7], amplitude),
                        "m",
                        "amplitude",
                    ),
                    "phase": variable(
                        ("probe", "angular_frequency"), np.stack([phase, phase]), "rad", "phase"
                    ),
                    "outcome": variable(
                        "angular_frequency",
                        np.where(lost, "diverged", "ok").astype(object),
                        "1",
                        "outcome",
                    ),
                    "failed_at": variable(
                        "angular_frequency", np.where(lost, 0.05, np.nan), "s", "failure time"
                    ),
                    "forcing": variable((), FORCING[scene], "1", "forcing"),
                    "seconds": variable((), 1.0, "s", "wall time"),
                },
                coords={
                    "angular_frequency": variable(
                        "angular_frequency", OMEGA * ratio, "rad/s", "forcing frequency"
                    ),
                    "probe": variable("probe", np.array(PROBES, dtype=object), "1", "probe"),
                },
            ),
            "frc",
            scene,
            model,
            "frc",
            seed,
        )

    def unfitted(self, scene, method, seed):
        reason = "the loss became infinite in epoch 7"
        fitted = xr.Dataset(
            {"outcome": variable((), "training_diverged", "1", "how the fit ended")}
        )
        self.save(fitted, "rom", scene, method, "rom", seed, reason=reason)
        for experiment in (
            "reconstruction",
            "decay",
            "backbone",
            "forced",
            "frc",
            "eigenvalues",
            "run_times",
        ):
            units = experiments.load(experiment).scores
            self.save(
                nothing(units, "training_diverged"), experiment, scene, method, experiment, seed
            )
            self.score(
                scene,
                method,
                seed,
                experiment,
                {name: (np.nan, unit) for name, unit in units.items()},
                "training_diverged",
            )

    def model(self, scene, method, seed):
        if (scene, method, seed) in self.unfit:
            self.unfitted(scene, method, seed)
            return
        error, fails = self.nmte[scene, method, seed], (scene, method, seed) in self.failures
        time = np.arange(self.periods * self.steps + 1) * PERIOD / self.steps
        true = self.decay_at_probes(scene, time)
        drift = (
            np.exp(-4 * time)
            * np.cos(OMEGA * (1 + error / 2000) * time)
            * SIZE[scene]
            * np.array([[1.0], [2.7]])
        )
        spiral = [np.exp((-4 + 1j * OMEGA * factor) * time) for factor in (1 + error / 2000, 1.0)]
        reduced, encoded = (np.stack([turn.real, -OMEGA * turn.imag], axis=1) for turn in spiral)
        coords = {
            "time": variable("time", time, "s", "time"),
            "probe": variable("probe", np.array(PROBES, dtype=object), "1", "probe"),
        }
        flat = variable("time", np.zeros(len(time)), "m", "error")
        scores = {"nmte_percent": (error, "percent")}
        fitted = xr.Dataset({"outcome": variable((), "ok", "1", "how the fit ended")})
        self.save(fitted, "rom", scene, method, "rom", seed)
        epochs = np.arange(0 if seed is None else 50)
        terms = {"total": 1.0, "reconstruction": 0.3, "acceleration_full": 0.7}
        losses = {
            f"{role}_{term}": variable(
                "epoch", scale * np.exp(-epochs / 12.0) + 1e-5, "1", f"{role} {term} loss"
            )
            for role in ("train", "test")
            for term, scale in terms.items()
        }
        self.save(
            xr.Dataset(losses, coords={"epoch": variable("epoch", epochs, "1", "epoch")}),
            "losses",
            scene,
            method,
            "losses",
            seed,
        )
        result = xr.Dataset(
            {"error": flat, **outcome_variables("ok")}, coords={"time": coords["time"]}
        )
        self.save(scored(result, scores), "reconstruction", scene, method, "reconstruction", seed)
        self.score(scene, method, seed, "reconstruction", scores)
        self.save(
            scored(
                xr.Dataset(
                    {
                        "error": flat,
                        "reduced": variable(
                            ("time", "coordinate"), reduced, "1", "reduced trajectory"
                        ),
                        "encoded": variable(
                            ("time", "coordinate"), encoded, "1", "true trajectory, encoded"
                        ),
                        "probe_displacement": variable(("probe", "time"), drift, "m", "predicted"),
                        "probe_true": variable(("probe", "time"), true, "m", "full order"),
                        **outcome_variables("ok", seconds=0.001),
                    },
                    coords=coords,
                ),
                scores,
            ),
            "decay",
            scene,
            method,
            "decay",
            seed,
        )
        self.score(scene, method, seed, "decay", scores)
        self.save(
            self.backbone(scene, 1 + error / 1e4), "backbone", scene, method, "backbone", seed
        )
        self.forced_run(scene, method, seed, 1 + error / 100, "diverged" if fails else "ok")
        self.curve(scene, method, seed, 1 + error / 100, fails)
        self.save(self.pair(-4.0, OMEGA + error), "eigenvalues", scene, method, "eigenvalues", seed)
        pair = {"real_per_s": (-4.0, "1/s"), "imaginary_rad_per_s": (OMEGA + error, "rad/s")}
        self.score(scene, method, seed, "eigenvalues", pair)
        mapping = 0.001 if seed is None else 30.0 + seed
        scores = dict(
            zip(
                RUN_TIMES,
                ((value, "s") for value in (2.0, mapping, 0.02, 0.001 + error / 1e3, 0.01, 0.8)),
            )
        )
        self.save(scored(xr.Dataset(), scores), "run_times", scene, method, "run_times", seed)
        self.score(scene, method, seed, "run_times", scores)

    def score(self, scene, method, seed, experiment, scores, outcome="ok"):
        for metric, (value, unit) in scores.items():
            number = -1 if seed is None else seed
            self.rows.append((scene, method, number, experiment, metric, value, unit, 0.1, outcome))


# Decay NMTE by hand. Deterministic: one value. Three seeds of split: median 3. Two of split_plus:
# median (1 + 2) / 2.
NMTE = {
    ("small", "modal_projection", None): 1.5,
    ("large", "modal_projection", None): 4.0,
    ("small", "split", 0): 3.0,
    ("small", "split", 1): 1.0,
    ("small", "split", 2): 8.0,
    ("large", "split", 0): 3.0,
    ("large", "split", 1): 1.0,
    ("large", "split", 2): 8.0,
    ("small", "split_plus", 0): 2.0,
    ("small", "split_plus", 1): 1.0,
    ("large", "split_plus", 0): 2.0,
}
# The forced runs that blow up: one seed of three, and the only run of modal projection.
FAILURES = {("large", "split", 1), ("large", "modal_projection", None)}
# The only training that went wrong.
UNFIT = {("large", "split_plus", 1)}
METHODS = {"modal_projection": None, "split": [0, 1, 2], "split_plus": [0, 1]}


@pytest.fixture(scope="session")
def tree(tmp_path_factory):
    """Two cases, three methods, up to three seeds, two forced runs that fail and a training that
    does.
    """
    return Tree(
        tmp_path_factory.mktemp("run") / "results",
        ["small", "large"],
        METHODS,
        NMTE,
        FAILURES,
        UNFIT,
    )


@pytest.fixture(scope="session")
def collection(tree):
    from vibrom.steps._files import collection

    return collection(tree.artefacts)


@pytest.fixture(scope="session")
def scores(tree):
    from vibrom.report.scores import Scores

    return Scores(pd.read_csv(tree.scores))
