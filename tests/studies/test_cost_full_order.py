"""The study of the full order: errors against SciPy's integrator, orders, and frequencies against
beam theory.
"""

import json

import numpy as np
import pytest
import xarray as xr
from scenes import SLENDER, body
from scipy.integrate import solve_ivp

from vibrom import effects, studies
from vibrom.artefacts.data import label, open_dataset, save_dataset, variable
from vibrom.artefacts.outcome import Outcome
from vibrom.bodies import space
from vibrom.models.full_order import FullOrder
from vibrom.models.measures import nmte_percent
from vibrom.solvers.full.newmark import Newmark, Record
from vibrom.steps import structure, study
from vibrom.studies import Case
from vibrom.studies.parts import cost_full_order, cost_meshes

PERIODS = 2
SCENE = {
    "body": body(cells=[3, 1], height=0.1),
    # The release excites the high modes, and damping proportional to the stiffness ends them.
    "effects": {
        "inertia": {"density": 440.0},
        "elasticity": SLENDER,
        "geometric_nonlinearity": {},
        "rayleigh_damping": {"damping_ratio": 0.01, "stiffness_factor": 1e-4},
        "modal_load": {"mode": 1},
    },
    "time": {
        "steps_per_period": 240,
        "every": 1,
        "alpha": 0.005,
        "residual": 1e-8,
        "initial_acceleration": "zero",
    },
    "record": {"periods": PERIODS},
    "experiments": {"forced": {"forcing": 2e3, "periods": PERIODS}},
}
SETTINGS = {
    "schemes": [
        {"alpha": 0.0, "initial_acceleration": "equilibrium"},
        {"alpha": 0.02, "initial_acceleration": "equilibrium"},
    ],
    "steps_per_period": [200, 400, 800],
    "residuals": [1e-3],
    "forced_periods": 2,
    "reference": {"steps_per_period": 6400, "residual": 1e-9},
    "meshes": {"bilinear": [[10, 1], [20, 1]], "quadratic": [[10, 1]]},
    "reference_mesh": {"element": "quadratic", "cells": [20, 1]},
    "mesh_periods": 1,
    "mesh_steps_per_period": 100,
}


def settings(**changes):
    """Each setting is run once."""
    return {"repeats": 1, "patience": 0.0, "full_order": SETTINGS | changes}


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    folder = tmp_path_factory.mktemp("cost")
    paths = {name: str(folder / f"{name}.nc") for name in ("structure", "release", "cost")}
    structure.run(structure=paths["structure"], scene=SCENE, name="slender", provenance={})
    phi = open_dataset(paths["structure"], "structure")["mode_shape"].values[0]
    shape = 0.05 * phi / np.abs(phi).max()
    release = xr.Dataset(
        {"displacement": variable(("role", "dof"), np.stack([shape, shape]), "m", "release")},
        coords={"role": variable("role", np.array(["train", "test"], dtype=object), "1", "role")},
    )
    save_dataset(label(release, "release", scene="slender", method="full_order"), paths["release"])
    study.run(
        output=paths["cost"],
        study={"name": "cost", "kind": "scene", "settings": settings()},
        names={"scene": "slender", "method": "full_order", "seed": None},
        case={"scene": SCENE},
        structure=paths["structure"],
        full_order=[paths["release"]],
        provenance={},
    )
    return (
        open_dataset(paths["structure"], "structure"),
        shape,
        open_dataset(paths["cost"], "cost_full_order"),
    )


def errors(dataset, question, **where):
    chosen = np.ones(dataset.sizes["setting"], bool)
    for name, value in where.items():
        chosen &= dataset[name].values == value
    return dataset["error"].sel(question=question).values[chosen]


def test_errors_are_those_against_an_integrator_of_order_eight(made):
    known, start, dataset = made
    body_space = space.build(SCENE["body"])
    term = effects.assemble(body_space, SCENE["effects"])
    mass, force = np.linalg.inv(term.mass.toarray()), term.forces[0]
    n, kernel = body_space.size, term.forces[0].kernels(1)[0]

    def rate(_, x):
        f = np.zeros((n, 1))
        q, v = np.ascontiguousarray(x[:n, None]), np.ascontiguousarray(x[n:, None])
        kernel(q, v, force.dofs, force.table, f)
        return np.concatenate(
            [x[n:], -mass @ (term.damping @ x[n:] + term.stiffness @ x[:n] + f[:, 0])]
        )

    period = (
        2
        * np.pi
        / (float(known["frequency"][0]) * np.sqrt(1 - float(known["damping_ratio"][0]) ** 2))
    )
    instants = np.arange(50 * PERIODS + 1) * period / 50
    exact = (
        solve_ivp(
            rate,
            (0, instants[-1] * (1 + 1e-12)),
            np.concatenate([start, 0 * start]),
            "DOP853",
            instants,
            rtol=1e-9,
            atol=1e-10,
        )
        .y[:n]
        .T
    )
    run = Newmark(tolerance=1e-8).run(
        term, start[:, None], np.array([period / 400]), 400 * PERIODS, record=Record(every=8)
    )
    independent = nmte_percent(exact, run.displacement[0])
    (told,) = errors(dataset, "decay", study="step", alpha=0.0, steps_per_period=400)
    own = float(dataset["reference_error"].sel(question="decay"))
    # Two errors against two references differ by no more than the references do; that of SciPy is
    # nothing.
    assert abs(told - independent) <= 1.5 * own and own < 0.02 * told


def test_orders(made):
    _, _, dataset = made
    for question in ("decay", "forced"):
        plain, damped = (
            errors(dataset, question, study="step", alpha=alpha) for alpha in (0.0, 0.02)
        )
        # Second order; the finest error carries that of the reference, 1/64 of it.
        assert np.log2(plain[:-1] / plain[1:]) == pytest.approx(2.0, abs=0.1)
        # Numerical damping adds a part proportional to alpha h.
        assert (np.log2(damped[:-1] / damped[1:]) < 1.6).all() and (damped > plain).all()
        assert float(dataset["reference_order"].sel(question=question)) == pytest.approx(
            2.0, abs=0.1
        )


def test_steps_that_are_no_multiple_of_the_samples_go_up_to_the_next(made):
    """240 steps to the period of the scene, 50 samples: 250."""
    _, _, dataset = made
    chosen = dataset["study"].values == "residual"
    assert (
        dataset["steps_per_period"].values[chosen].tolist() == [250]
        and (dataset["error"].sel(question=["decay", "forced"]).values[chosen] > 0).all()
    )


def test_meshes_against_beam_theory(made):
    """omega = 1.8751^2 sqrt(E I / (rho A)) / L^2 for a slender beam; shear and rotation take 0.6 %
    at L/h = 10.
    """
    _, _, dataset = made
    exact = 1.875104**2 * np.sqrt(SLENDER["young_modulus"] * 0.1**2 / 12 / 440.0)
    mesh = dataset["study"].values == "mesh"
    element, omega = dataset["element"].values[mesh], dataset["first_frequency"].values[mesh]
    assert omega[element == "quadratic"] == pytest.approx(exact, rel=0.01)
    coarse, fine = omega[element == "bilinear"]
    assert coarse > fine > 1.02 * exact  # locked in shear, less so on the finer mesh
    told = errors(dataset, "frequency", study="mesh", element="bilinear")
    assert told == pytest.approx(100 * np.abs(np.array([coarse, fine]) / exact - 1), abs=1.0)


def test_a_mesh_without_a_node_for_an_effect_is_skipped():
    """x = 0.35 m is a node of 20 cells, and of 10 not."""
    scene = {**SCENE, "effects": {**SCENE["effects"], "tip_mass": {"at": [0.35, 0.0], "mass": 0.1}}}
    varied = settings(meshes={"bilinear": [[10, 1], [20, 1]]}, mesh_steps_per_period=50)
    (first, second), _ = cost_meshes.made(
        studies.study("cost", varied), Case(scene, structure=None)
    )
    assert [answer.outcome for answer in first[1].values()] == [Outcome.SKIPPED] * 2
    assert [answer.outcome for answer in second[1].values()] == [Outcome.OK] * 2
    assert np.isnan(first[1]["frequency"].error) and second[1]["frequency"].error > 0


def test_a_setting_that_stands_in_both_lists_is_run_once(made, monkeypatch):
    """The scene's residual at its own number of steps, which goes up to 250."""
    known, _, _ = made
    run, scene = [], {**SCENE, "time": {**SCENE["time"], "residual": 1e-3}}

    def answer(question, model):
        run.append((model.steps_per_period, model.newmark.tolerance))
        return np.ones((2, 2)), 1.0, Outcome.OK

    monkeypatch.setattr(cost_full_order.Question, "answer", answer)
    varied = settings(schemes=SETTINGS["schemes"][:1], steps_per_period=[200, 250])
    question = cost_full_order.Question(np.zeros(2), 1)
    found = list(
        cost_full_order.in_time(
            studies.study("cost", varied),
            Case(scene, known),
            FullOrder.of_scene(scene, known),
            {"decay": question},
            {"decay": np.ones((2, 2))},
        )
    )
    assert [record["study"] for record, _ in found] == ["step", "step", "residual"]
    assert run == [(200, 1e-3), (250, 1e-3)] and found[1][1] is found[2][1]


def test_the_artefact_says_on_what_machine(made):
    _, _, dataset = made
    hardware = json.loads(dataset.attrs["hardware"])
    assert set(hardware) == {"processor", "cores", "memory_gib", "threads", "load", "system"}
    assert hardware["cores"] >= 1
    run = dataset["outcome"].values != Outcome.NOT_RUN
    assert (dataset["calls"].values[run] == 1).all()
