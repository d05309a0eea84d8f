"""What a job of a study is given, in the scene of two masses."""

import numpy as np
import two_dofs
import xarray as xr

from vibrom.artefacts.data import label, outcome_variables, scored, variable
from vibrom.experiments import experiment
from vibrom.studies import Case, Fitted

TIME = {
    "steps_per_period": 8 * two_dofs.SAMPLES,
    "every": 8,
    "alpha": 0.0,
    "residual": 1e-8,
    "initial_acceleration": "equilibrium",
}
EXPERIMENTS = {
    "decay": {},
    "forced": {"forcing": 0.05, "periods": 20},
    "frc": {"forcing": 0.05, "periods": 20, "frequencies": 5},
    "eigenvalues": {},
}
INTEGRATOR = {"rtol": 1e-8, "atol": 1e-10}


def full_order():
    """What the full order answers, and its record."""
    model, found = two_dofs.full_order(), {"train": two_dofs.record(), "test": two_dofs.record()}
    for name in ("forced", "frc"):
        answer = experiment(name, EXPERIMENTS[name]).ask(model, two_dofs.given())
        found[name] = label(scored(answer, {}, {}), name, scene="two", method="full_order")
    return found


def fit(rom, method="exact", seed=None, outcome="ok"):
    """The record of a fit."""
    stored = rom.to_dataset()
    record = stored.assign(
        outcome=variable((), outcome, "1", "fit"),
        data_seconds=variable((), 1.0, "s", "data"),
        mapping_seconds=variable((), 3.0, "s", "mapping"),
        dynamics_seconds=variable((), 0.5, "s", "dynamics"),
    )
    return label(record.assign_attrs(stored.attrs), "rom", scene="two", method=method, seed=seed)


def answers(value=7.0, seconds=0.25, outcome="ok"):
    """Answers of a model that the run is said to have given."""
    points = np.full(EXPERIMENTS["frc"]["frequencies"], outcome, dtype=object)
    found = {}
    for name in EXPERIMENTS:
        scores = dict(experiment(name, EXPERIMENTS[name]).scores)
        answer = xr.Dataset(outcome_variables(outcome, seconds=seconds))
        if name == "frc":
            curve = np.full((2, len(points)), value)
            answer = answer.assign(
                outcome=variable("angular_frequency", points, "1", "outcome"),
                amplitude=variable(("probe", "angular_frequency"), curve, "m", "amplitude"),
            )
        answer = scored(answer, dict.fromkeys(scores, value), scores)
        found[name] = label(answer, name, scene="two", method="exact", answered=1)
    return found


def case(*models, **changes):
    """Of these records of fits, each with the answers above."""
    blocks = {"body": {}, "effects": {}, "record": {"periods": two_dofs.PERIODS}, "time": TIME}
    given = {
        "scene": blocks | {"experiments": EXPERIMENTS},
        "structure": two_dofs.structure(),
        "full_order": full_order(),
        "fitted": tuple(Fitted(model, answers()) for model in models),
        "integrator": INTEGRATOR,
        "seed": 0,
    }
    return Case(**(given | changes))
