"""Promised bounds: met, not met and missing by hand, and cases that are not the thesis's are left
alone.
"""

import json

import numpy as np
import pytest
import studies
import xarray as xr

from vibrom.artefacts.data import outcome_variables
from vibrom.artefacts.outcome import Tally
from vibrom.report import tables
from vibrom.report.collection import Collection, Key
from vibrom.report.scores import Score, Scores
from vibrom.report.tables import checks
from vibrom.thesis import promises
from vibrom.thesis import published as thesis

PROBES = ["probe", "tip", "tip_x"]


def structure(omega=398.0524, body=None, effects=None):
    attrs = {
        "body": json.dumps({**promises.BODY, "clamped": ["left"]} | (body or {})),
        "effects": json.dumps(promises.EFFECTS | (effects or {})),
    }
    variables = {"frequency": ("mode", [omega]), "probe_dof": ("probe", [0, 1, 2])}
    return xr.Dataset(variables, {"probe": PROBES}, attrs)


def release(off=0.0, recipes=None):
    states = np.array(
        [
            [thesis.state("small", role)[f"{probe}_m"] for probe in PROBES]
            for role in ("train", "test")
        ]
    )
    states[0, 1] *= 1 + off
    return xr.Dataset(
        {"displacement": (("role", "dof"), states)},
        {"role": ["train", "test"]},
        {"releases": json.dumps(recipes or {})},
    )


def forced(tip=0.00095, outcome="ok", forcing=1.0):
    # 9 m before the last period
    motion = np.array([[0, 0, 0, 0], [0, 9, tip / 2, -tip], [0, 0, 0, 0]])
    variables = {"probe_displacement": (("probe", "time"), motion), "forcing": forcing}
    coords = {"probe": PROBES, "time": [0.0, 1.0, 2.0, 3.0], "last_time": [2.0, 3.0]}
    return xr.Dataset({**variables, **outcome_variables(outcome)}, coords)


def run(method=None, values=(), outcome="ok", **full):
    """The checks of the case small; `values` are (experiment, metric, value)."""
    full = {"structure": structure(), "release": release(), "forced": forced()} | full
    loaders = {
        Key("small", "full_order", None, name): (lambda data=data: data)
        for name, data in full.items()
        if data is not None
    }
    if method:
        for name in ("reconstruction", "decay", "eigenvalues", "forced"):
            answer = xr.Dataset(outcome_variables(outcome))
            loaders[Key("small", method, 0, name)] = lambda answer=answer: answer
    rows = [Score("small", method, 0, *value, "1", 0.1, Tally([outcome])) for value in values]
    own = ("eigenvalues", "imaginary_rad_per_s", 398.03, "rad/s", 0.1, Tally(["ok"]))
    rows.append(Score("small", "full_order", None, *own))
    return tables.make("checks", Collection(loaders), Scores(rows)).rows


def met(rows, quantity, method="full_order"):
    return [row["met"] for row in rows if (row["method"], row["quantity"]) == (method, quantity)]


def test_the_full_order_within_and_outside_its_bounds():
    good = run()
    assert {row["met"] for row in good} == {"yes"} and len(good) == 9
    assert met(run(structure=structure(398.0535)), "omega_1") == ["no"]
    assert met(run(release=release(0.0009)), "train release, tip") == ["yes"]
    assert met(run(release=release(0.0011)), "train release, tip") == ["no"]
    assert met(run(forced=forced(0.000954)), "forced, largest tip") == ["yes"]
    assert met(run(forced=forced(0.000956)), "forced, largest tip") == ["no"]


def test_a_missing_number_is_not_met():
    assert met(run(release=None), "test release, tip_x") == ["no"]
    failed = run(forced=forced(outcome="no_convergence"))
    assert met(failed, "forced, largest tip") == ["no"]
    assert met(failed, "forced, cells without value or outcome") == ["yes"]  # it says why
    assert {row["met"] for row in run("split") if row["method"] == "split"} == {"no"}


@pytest.mark.parametrize(
    ("body", "effects"),
    [
        ({"cells": [80, 4]}, {}),
        ({"element": "quadratic"}, {}),
        ({}, {"inertia": {"density": 4400.0}}),
        ({}, {"gravity": {}}),
    ],
)
def test_another_beam_is_not_compared(body, effects):
    rows = run("split", structure=structure(300.0, body, effects))
    left, *others = sorted(rows, key=lambda row: row["met"] != checks.NOT_COMPARED)
    assert left["met"] == checks.NOT_COMPARED and "and not" in left["source"]
    assert {row["quantity"] for row in others} == {"forced, cells without value or outcome"}


def test_a_setting_that_the_thesis_does_not_name_has_the_effect_s_default():
    """With it written out the beam is the same; with another value a row says which."""
    written = {"rayleigh_damping": {"damping_ratio": 0.01, "stiffness_factor": 0.0}}
    assert {row["met"] for row in run(structure=structure(effects=written))} == {"yes"}
    written["rayleigh_damping"]["stiffness_factor"] = 0.1
    rows = run(structure=structure(effects=written))
    (left,) = [row for row in rows if row["met"] == checks.NOT_COMPARED]
    assert left["source"] == "effects.rayleigh_damping.stiffness_factor = 0.1, and not 0.0"


def test_another_release_or_forcing_is_not_compared():
    recipes = {"train": {"forcing": 700.0, "step": 4545}}
    rows = run(release=release(0.5, recipes), forced=forced(1.0, forcing=2.0))
    (left,) = [row for row in rows if row["met"] == checks.NOT_COMPARED]
    assert left["source"] == "not the thesis's: forced, train"
    quantities = {row["quantity"] for row in rows} - {left["quantity"]}
    assert "forced, largest tip" not in quantities and "forced, largest tip" in left["quantity"]
    assert not any(quantity.startswith("train release") for quantity in quantities)
    assert met(rows, "test release, tip") == ["yes"]


OTHER = {"forcing": 700.0, "step": 4545}


@pytest.mark.parametrize(
    ("changed", "left"),
    [
        ({"release": release(recipes={"train": OTHER})}, set()),
        ({"release": release(recipes={"test": OTHER})}, {"forced NMTE"}),
        ({"forced": forced(forcing=2.0)}, {"reconstruction NMTE", "decay NMTE"}),
        ({}, {"reconstruction NMTE", "decay NMTE", "forced NMTE"}),
    ],
)
def test_models_are_compared_where_all_that_their_answer_depends_on_is_the_thesis_s(changed, left):
    errors = {"reconstruction": 0.08, "decay": 0.2, "forced": 0.18}
    values = [(name, "nmte_percent", error) for name, error in errors.items()]
    rows = run("split_plus", values, **changed)
    own = [row for row in rows if row["method"] == "split_plus" and row["source"] != "promise"]
    compared = [row for row in own if row["met"] != checks.NOT_COMPARED]
    assert {row["quantity"] for row in compared} == left
    curve = {Key("small", "full_order", None, "frc"): lambda: forced(forcing=2.0)}
    assert checks.as_printed("small", Collection(curve)) == {"train", "test", "forced", "branches"}


def test_trained_methods_against_the_thesis():
    errors = {"reconstruction": 0.08, "decay": 0.3, "forced": 0.18}
    rows = run("split_plus", [(name, "nmte_percent", error) for name, error in errors.items()])
    # 0.086916, 0.27806 and 0.18596 are printed
    found = [met(rows, f"{name} NMTE", "split_plus") for name in errors]
    assert found == [["yes"], ["no"], ["yes"]]


def test_deterministic_methods_against_the_thesis():
    values = [("eigenvalues", "real_per_s", -3.99), ("eigenvalues", "imaginary_rad_per_s", 405.0)]
    values += [("reconstruction", "nmte_percent", 0.0211), ("decay", "nmte_percent", 0.0718)]
    rows = run("ssmlearn", values)
    quantities = ("reconstruction NMTE", "decay NMTE", "eigenvalue, real part")
    assert [met(rows, name, "ssmlearn") for name in quantities] == [["yes"]] * 3
    assert met(rows, "eigenvalue, imaginary part", "ssmlearn") == ["no"]


def test_sindy_has_bounds_of_its_own():
    values = [("decay", "nmte_percent", 50.0), ("eigenvalues", "real_per_s", 0.2)]
    rows = run("sindy_autoencoder", [*values, ("eigenvalues", "imaginary_rad_per_s", 380.0)])
    method = "sindy_autoencoder"
    assert met(rows, "decay NMTE", method) == ["yes", "no"]  # the thesis has 111
    assert met(rows, "eigenvalue, real part", method) == ["no"]
    assert met(rows, "eigenvalue, imaginary part", method) == ["yes"]


def test_a_cell_has_a_value_or_a_word(collection, scores):
    quantity = "forced, cells without value or outcome"
    assert met(run("split", outcome="diverged"), quantity, "split") == ["yes"]
    assert met(run("split"), quantity, "split") == ["no"]
    for motion, kept in ((forced(), "yes"), (forced(np.nan), "no")):
        without_tip = motion.assign_coords(probe=["probe", "middle", "end"])
        assert met(run(forced=without_tip), quantity) == [kept]
    rows = tables.make("checks", collection, scores).rows  # 8 x 2 cells: not the thesis's beam
    rows = [row for row in rows if row["met"] != checks.NOT_COMPARED]
    assert len(rows) == 2 * 4 * 2 and {row["met"] for row in rows} == {"yes"}


def test_what_no_method_was_asked_is_not_missed(real):
    """The full order's runs are part of every run."""
    kept = Collection(
        {
            key: made
            for key, made in real.loaders.items()
            if key.model == "full_order" or key.name in ("rom", "losses", "decay")
        }
    )
    made = tables.make("checks", kept, Scores.of(kept)).rows
    missed = {
        (row["method"], row["quantity"]) for row in made if "cells without" in row["quantity"]
    }
    assert {method for method, _ in missed} == {"full_order"}
    lost = [key for key in real.loaders if key.model == "split" and key.name == "forced"][0]
    less = Collection({key: made for key, made in real.loaders.items() if key != lost})
    rows = tables.make("checks", less, Scores.of(less)).rows
    quantity = "forced, cells without value or outcome"
    (row,) = (
        one
        for one in rows
        if one["quantity"] == quantity and one["method"] == "split" and one["case"] == lost.scene
    )
    assert row["value"] == 1.0 and row["met"] == "no"


def test_bounds():
    assert promises.within(10.0, 1.0).met(10.1) and not promises.within(10.0, 1.0).met(10.11)
    assert promises.at_most(2.0).met(2.0) and not promises.below(2.0).met(2.0)
    assert not any(bound.met(np.nan) for bound in (promises.at_most(2.0), promises.OMEGA_1))
    assert not promises.within(np.nan, 1.0).met(1.0)


@pytest.mark.parametrize(
    ("factor", "kept"),
    [
        ([1.0, 1.01, 1.0, 1.0, 1.0], ["yes"] * 4),
        ([1.0, 1.0, np.nan, 1.0, 1.0], ["no", "yes", "no", "no"]),  # a gap has no peak
        ([1.029] * 5, ["yes", "no", "yes", "yes"]),
        ([1.0, 1.0, 1.04, 1.0, 1.0], ["yes", "yes", "no", "yes"]),
    ],
)
def test_guarded_response_curves_have_bounds_of_their_own(factor, kept):
    answer = studies.robustness(0, 0, studies.TRUTH, 1.0)
    answer = answer.assign_attrs(method="split_plus").assign_coords(guard=["none", "dissipative_9"])
    answer["frc_amplitude"][1, 0] = studies.TRUTH * factor
    loaders = {
        Key("folding", "full_order", None, "frc"): studies.response_curve,
        Key("folding", "split_plus", 0, "robustness"): lambda: answer,
    }
    found = []
    for promise in promises.of_method("folding", "split_plus", 398.0):
        if promise.at[0] == "guards":
            at = (promise.at, "folding", "split_plus")
            value = checks.measured(*at, Collection(loaders), Scores([]))
            found.append("yes" if promise.bound.met(value) else "no")
            absent = checks.measured(promise.at, "folding", "ssmlearn", Collection(loaders), None)
            assert absent is None
    assert found == kept
