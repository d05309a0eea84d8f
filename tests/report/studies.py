"""Artefacts of the studies with numbers that are chosen."""

import numpy as np
import xarray as xr

from vibrom.artefacts.data import label, variable
from vibrom.studies.parts import grid

OMEGA, PERIOD = 400.0, 2 * np.pi / 400.0
PROBES = ["probe", "tip"]
TRUTH = np.array([1.0, 2.0, 4.0, 2.0, 1.0])  # m, a response curve


def text(words) -> np.ndarray:
    """As netCDF keeps it."""
    return np.array(words, dtype=object)


def dataset(kind: str, method: str, seed, values: dict, coords: dict, scene: str = "small"):
    """`values`: name -> (dims, values, units)."""
    named = {name: variable(*item, name.replace("_", " ")) for name, item in values.items()}
    axes = {name: variable(name, item, "1", name) for name, item in coords.items()}
    return label(xr.Dataset(named, axes), kind, scene=scene, method=method, seed=seed)


def ablation():
    """Without damping nothing decays, and a step costs half; elasticity cannot be left out, and
    without its stop the body fails.
    """
    time, last = np.arange(0, 6 * PERIOD, PERIOD / 20), np.arange(21) * PERIOD / 20
    left_out, known = text(["nothing", "elasticity", "damping", "stop"]), [1.0, np.nan, 1.0, np.nan]
    known, amplitude = np.array(known), 0.05 * np.array([0.5, np.nan, 0.75, np.nan])
    rate, sizes = np.array([30, 30, 0, 30])[:, None, None], np.array([1.0, 2.7])
    decay = 0.05 * sizes[:, None] * np.cos(OMEGA * time) * np.exp(-rate * time)
    at = ("left_out", "probe")
    values = {
        "first_frequency": ("left_out", OMEGA * known, "rad s-1"),
        "decay_nmte": ("left_out", [0.0, np.nan, 16.0, np.nan], "percent"),
        "decay_frequency": (at, np.outer(OMEGA * known, [1, 1]), "rad s-1"),
        "decay_amplitude": (at, np.outer(amplitude, sizes), "m"),
        "forced_amplitude": (at, np.outer(amplitude, sizes), "m"),
        "decay_displacement": ((*at, "time"), decay * known[:, None, None], "m"),
        "forced_displacement": (
            (*at, "last_time"),
            np.einsum("i,j,k->ijk", amplitude, sizes, np.sin(OMEGA * last)),
            "m",
        ),
        "iterations_per_step": ("left_out", 2 * known, "1"),
        "seconds_per_step": ("left_out", 2e-5 * known * [1, 1, 0.5, 1], "s"),
        "seconds_ratio": ("left_out", known * [1, 1, 2, 1], "1"),
        "outcome": ("left_out", text(["ok", "needed", "ok", "no_convergence"]), "1"),
        "needed_by": ("left_out", text(["", "modal_load inertia", "", ""]), "1"),
        "failed_at": ("left_out", [np.nan, np.nan, np.nan, 0.01], "s"),
        "advised": ((), "damping", "1"),
        "advised_error": ((), 1.5, "percent"),
        "advised_ratio": ((), 2.0, "1"),
        "sets_tried": ((), 5, "1"),
    }
    coords = {"left_out": left_out, "time": time, "last_time": last, "probe": text(PROBES)}
    made = dataset("ablation", "full_order", None, values, coords)
    return made.assign_attrs(tolerance=0.05)


# Steps, damping -> error [%]: 4e3 / N^2, and 40 / N more per 0.005 of damping; seconds = N / 1000.
STEPS = (100, 200, 400, 800, 1600)


def cost_full_order():
    """Time steps of two schemes, of which one does not converge with the largest, and meshes."""
    rows = []
    for alpha in (0.0, 0.005):
        for steps in STEPS:
            lost = (alpha, steps) == (0.0, 100)
            error = np.nan if lost else 4e3 / steps**2 + alpha / 0.005 * 40 / steps
            answer = (error, steps / 1000, "no_convergence" if lost else "ok")
            about = (
                "step",
                "bilinear",
                40,
                2,
                240,
                steps,
                "newmark",
                alpha,
                "equilibrium",
                1e-6,
                np.nan,
            )
            rows.append((about, [answer, answer, None, None]))
    for element, columns, error in (
        ("bilinear", 40, 27.5),
        ("bilinear", 80, 7.6),
        ("quadratic", 10, 0.5),
    ):
        answer, omega = (error, columns / 100, "ok"), 312.1 * (1 + error / 100)
        about = (
            "mesh",
            element,
            columns,
            1,
            columns,
            500,
            "newmark",
            0.005,
            "equilibrium",
            1e-6,
            omega,
        )
        rows.append((about, [None, None, answer, answer]))
    names = ("study", "element", "columns", "rows", "free_dofs", "steps_per_period", "scheme")
    names += ("alpha",)
    names += ("initial_acceleration", "residual", "first_frequency")
    values = {
        name: ("setting", text(column) if isinstance(column[0], str) else list(column), "1")
        for name, column in zip(names, zip(*(about for about, _ in rows)))
    }
    questions = ["decay", "forced", "frequency", "response"]
    values |= answers([given for _, given in rows])
    values["reference_error"] = ("question", np.full(4, 0.004), "percent")
    return dataset("cost_full_order", "full_order", None, values, {"question": text(questions)})


def answers(rows) -> dict:
    """Of (error, seconds, outcome) or None by setting and question."""
    dims, absent = ("setting", "question"), (np.nan, np.nan, "not_run")
    columns = [[[(given or absent)[at] for given in row] for row in rows] for at in range(3)]
    return {
        "error": (dims, np.array(columns[0]), "percent"),
        "seconds": (dims, np.array(columns[1]), "s"),
        "outcome": (dims, text(columns[2]), "1"),
    }


def cost_reduced():
    """Three seeds of one method, trained for three lengths, and a model whose forced runs fail."""
    rows = [("split", seed, "as configured", "", 10.0 + seed, error) for seed, error in SEEDS]
    rows += [("split", 0, "epochs", "100", 1.0, 8.0), ("split", 0, "epochs", "300", 3.0, 2.0)]
    rows += [
        ("modal_projection", -1, "as configured", "", 0.1, 12.0),
        ("modal_projection", -1, "order", "5", 0.2, 4.0),
    ]
    given = []
    for method, _, _, _, mapping, error in rows:
        good, bad = (error, 0.01 * mapping, "ok"), (np.nan, 0.001, "diverged")
        given.append([good, *[bad if method == "modal_projection" else good] * 2])
    method, seed, varied, set_to, mapping, _ = zip(*rows)
    values = {
        "model": ("setting", text(method), "1"),
        "model_seed": ("setting", list(seed), "1"),
        "varied": ("setting", text(varied), "1"),
        "value": ("setting", text(set_to), "1"),
        "data_seconds": ("setting", np.full(len(rows), 2.0), "s"),
        "mapping_seconds": ("setting", list(mapping), "s"),
        "dynamics_seconds": ("setting", np.full(len(rows), 0.5), "s"),
        **answers(given),
    }
    questions = {"question": text(["decay", "forced", "frc"])}
    return dataset("cost_reduced", "full_order", None, values, questions)


SEEDS = ((0, 0.5), (1, 0.7), (2, 3.0))  # seed, error in percent
CASES = grid.cases([1.0, 2.0], np.linspace(0.9, 1.1, 3), 2, 1.3)  # ten runs


def robustness(seed: int, lost: int, curve, nmte: float, guarded: str = "ok"):
    """A seed that lost this many of its ten runs without a guard, and none with one."""
    guards, integrators, runs = ["none", "bounded"], ["tight", "loose"], len(CASES.kind)
    pair, shape = ("guard", "integrator"), (2, 2)
    outcome = np.full((*shape, runs), "ok", dtype=object)
    outcome[..., -1] = "left_range"
    outcome[0, 0, :lost] = "diverged"
    outcome[1, 0], outcome[1, 1] = outcome[1, 0] if guarded == "ok" else guarded, "not_run"
    ended = np.full((*shape, len(TRUTH)), "ok", dtype=object)
    ended[1, 0], ended[1, 1] = guarded, "not_run"
    failed_at = np.full((*shape, runs), np.nan)
    failed_at[0, 0, :lost] = np.arange(1, lost + 1)
    amplitude = np.array([[curve, TRUTH], [TRUTH, TRUTH * np.nan]])
    energy = np.tile(np.exp(-np.arange(50.0)), (2, 2, 1))
    energy[0, 0, 3] = 1.0  # grows once in one decay
    decay = np.ones(shape)
    decay[0, 0] = nmte
    values = {
        "outcome": ((*pair, "run"), outcome, "1"),
        "failed_at": ((*pair, "run"), failed_at, "1"),
        "range_ratio": ((*pair, "run"), np.full((*shape, runs), 1.2), "1"),
        "kind": ("run", text(np.array(grid.KINDS)[CASES.kind]), "1"),
        "forcing": ("run", CASES.forcing, "1"),
        "frequency": ("run", CASES.frequency, "1"),
        "energy": (("guard", "release", "period"), energy, "J"),
        "envelope": (
            ("guard", "release", "period"),
            np.exp(-np.arange(50.0) / 2) + 0 * energy,
            "1",
        ),
        "frc_amplitude": ((*pair, "angular_frequency"), amplitude, "m"),
        "frc_outcome": ((*pair, "angular_frequency"), ended, "1"),
        "decay_nmte": (pair, decay, "percent"),
        "forced_nmte": (pair, np.ones(shape), "percent"),
        "real_part": (pair, np.full(shape, -4.0), "s-1"),
    }
    coords = {"guard": text(guards), "integrator": text(integrators)}
    return dataset("robustness", "split", seed, values, coords, "folding")


def response_curve():
    """The full order's."""
    values = {
        "amplitude": (("probe", "angular_frequency"), TRUTH[None], "m"),
        "phase": ((), 0.0, "rad"),
        "outcome": ((), "ok", "1"),
        "failed_at": ((), np.nan, "s"),
        "seconds": ((), 1.0, "s"),
    }
    coords = {"angular_frequency": np.arange(5.0)}
    return dataset("frc", "full_order", None, values, coords, "folding")


def coarse_steps():
    """The full order does not converge at its peak with twenty steps a period."""
    dims, shape = ("steps_per_period", "scheme", "forcing"), (2, 1, 2)
    ended = np.full((*shape, 5), "ok", dtype=object)
    ended[0, :, :, 2] = "no_convergence"
    good = ended == "ok"
    values = {
        "outcome": ((*dims, "angular_frequency"), ended, "1"),
        "failed_at": ((*dims, "angular_frequency"), np.where(good, np.nan, 7.0), "1"),
        "amplitude": ((*dims, "angular_frequency"), np.where(good, 0.9 * TRUTH, np.nan), "m"),
        "reference": ("angular_frequency", TRUTH, "m"),
        "seconds": (dims, np.ones(shape), "s"),
    }
    values |= {"alpha": ("scheme", [0.05], "1"), "time_scheme": ("scheme", text(["newmark"]), "1")}
    coords = {"steps_per_period": [20, 100], "forcing": [1.0, 2.0]}
    coords |= {"angular_frequency": np.arange(5.0)}
    return dataset("robustness", "full_order", None, values, coords, "folding")
