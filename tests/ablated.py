"""The study of ablation, asked about a small body."""

import xarray as xr
from scenes import ELASTICITY

from vibrom.artefacts.data import label, open_dataset, save_dataset, variable
from vibrom.steps import structure, study

# a period; the period error (2 pi/400)^2/12 = 2e-5 a radian is the same with and without an effect
STEPS = 400
ZETA = 0.01
TIP = {"at": [1.0, 0.0], "direction": "y"}
INERTIA, DAMPING = {"inertia": {"density": 440.0}}, {"rayleigh_damping": {"damping_ratio": ZETA}}
LINEAR = {**INERTIA, "elasticity": ELASTICITY}


def ask(
    folder,
    shape,
    listed,
    release,
    forcing=1.0,
    decay_periods=10,
    forced_periods=20,
    repeats=1,
    **time,
):
    """The answers about this body; `release` gives the release state (n,) from its space and first
    mode.
    """
    scene = {
        "body": {**shape, "probes": {"tip": TIP}},
        "effects": listed,
        "experiments": {"forced": {"forcing": forcing}},
        "time": {
            "steps_per_period": STEPS,
            "every": 4,
            "alpha": 0.0,
            "residual": 1e-8,
            "initial_acceleration": "equilibrium",
            **time,
        },
    }
    paths = {name: str(folder / f"{name}.nc") for name in ("structure", "release", "output")}
    structure.run(structure=paths["structure"], scene=scene, name="tested", provenance={})
    made = open_dataset(paths["structure"], "structure")
    start = release(made["mode_shape"].values[0], int(made["probe_dof"].values[0]))
    states = xr.Dataset(
        {"displacement": variable(("role", "dof"), start[None], "m", "release")},
        coords={"role": variable("role", ["test"], "1", "role")},
    )
    save_dataset(label(states, "release", scene="tested", method="full_order"), paths["release"])
    lengths = {
        "decay_periods": decay_periods,
        "forced_periods": forced_periods,
        "timed_periods": 2,
        "repeats": repeats,
    }
    study.run(
        output=paths["output"],
        study={"name": "ablation", "kind": "scene", "settings": lengths},
        names={"scene": "tested", "method": "full_order", "seed": None},
        case={"scene": scene},
        structure=paths["structure"],
        full_order=[paths["release"]],
        provenance={},
    )
    return open_dataset(paths["output"], "ablation").isel(probe=0), made


def bent(tip):
    """The first mode, `tip` metres high at the tip: a linear body released from it moves in it."""
    return lambda mode, at: tip * mode / mode[at]


def outcomes(answers):
    return dict(zip(answers["left_out"].values, answers["outcome"].values))
