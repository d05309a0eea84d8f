"""The study of the methods: what is fitted and evaluated, what is read from the run, and a value
that does not go with the method's other settings.
"""

from dataclasses import replace

import numpy as np
import pytest
import two_dof_case
import two_dofs

from vibrom import studies
from vibrom.artefacts.outcome import Outcome
from vibrom.methods.ssmlearn import SsmLearn
from vibrom.models.recorded import structure, trajectory
from vibrom.models.rollout import Integrator
from vibrom.models.training import Training
from vibrom.studies.parts import cost_reduced
from vibrom.studies.parts.cost_reduced import QUESTIONS, known, recipe, varied
from vibrom.studies.parts.fits import Fits

# Both masses' modes decay alike, which ties squares of the coordinates to one another: more than
# linear terms are not determined.
LINEAR = {"modes": 2, "order_decoder": 1, "order_dynamics": 1}
METHOD = {"kind": "ssmlearn", "settings": LINEAR, "seeded": False, "start": None}
METHODS = {
    "ssmlearn_2": METHOD,
    "later": {"kind": "split_plus", "settings": {}, "seeded": False, "start": "ssmlearn_2"},
    "outside": {"kind": None, "settings": {"degree": 3}, "seeded": False, "start": None},
}
SETTINGS = {"repeats": 1, "patience": 0.0}


@pytest.fixture(scope="module")
def case():
    """Two masses that decay, an SSMLearn of two modes that the run has fitted, and an outside
    model.
    """
    empty = two_dof_case.case()
    training = Training((trajectory(two_dofs.record()),), structure(empty.structure))
    fitted = two_dof_case.fit(SsmLearn(**LINEAR).learn(training), "ssmlearn_2")
    outside = two_dof_case.fit(two_dofs.rom(), "outside")
    return two_dof_case.case(fitted, outside, methods=METHODS)


def made(case, **reduced):
    """The study's dataset where these are varied."""
    sweeps = {
        method: [{"vary": list(vary), "over": over} for vary, over in sweeps]
        for method, sweeps in reduced.items()
    }
    return studies.study("cost", SETTINGS | {"reduced": sweeps}).job("models", case)


def settings(dataset, **where):
    """The entries where these variables have these values."""
    chosen = np.ones(dataset.sizes["setting"], bool)
    for name, value in where.items():
        chosen &= dataset[name].values == value
    return dataset.isel(setting=chosen)


@pytest.mark.parametrize(
    "changes, cure",
    [
        ({"dissipative": 5}, "set dissipative: 0"),
        ({"modes": 3}, "choose 1 to 2"),
        ({"extrapolation": "flat"}, "extrapolation"),
    ],
)
def test_a_setting_that_does_not_go_with_the_others_is_skipped(case, capsys, changes, cure):
    study = studies.study("cost", SETTINGS)
    (record,) = varied(study, case, [("ssmlearn_2", changes)])
    assert list(record["outcome"]) == [Outcome.SKIPPED] * len(QUESTIONS)
    assert cure in capsys.readouterr().err


def test_a_model_of_the_run_is_read_and_not_evaluated(case, monkeypatch):
    monkeypatch.setattr(cost_reduced, "measured", None)
    dataset = settings(made(case), varied="as configured")
    assert dataset["model"].values.tolist() == ["ssmlearn_2", "outside"]
    assert (dataset["error"].values == 7.0).all() and (dataset["seconds"].values == 0.25).all()
    assert dataset["mapping_seconds"].values.tolist() == [3.0, 3.0]
    assert dataset["data_seconds"].values.tolist() == [1.0, 1.0]  # of the record


def test_a_model_of_the_run_that_failed_has_its_word(case):
    lost = replace(case.fitted[0], answers=two_dof_case.answers(np.nan, outcome="diverged"))
    never = lost.answers["frc"].drop_vars("amplitude").assign_attrs(answered=0)
    lost = replace(lost, answers={**lost.answers, "frc": never})
    found = known(lost)
    assert {answer.outcome for answer in found.values()} == {Outcome.DIVERGED}
    assert found["decay"].seconds == 0.25 and np.isnan(found["frc"].seconds)


def test_a_recipe_that_the_run_has_is_not_fitted_again(case, monkeypatch):
    """The setting that it has anyway, also where it is a default that is not written."""
    monkeypatch.setattr(Fits, "fit", None)
    dataset = made(case, ssmlearn_2=[(["modes"], [2]), (["dissipative"], [0]), (["thin"], [1])])
    again = settings(dataset, model="ssmlearn_2")
    assert again.sizes["setting"] == 4 and (again["error"].values == 7.0).all()


def test_one_recipe_is_fitted_once_whichever_method_it_belongs_to(case):
    fits = Fits(case, 1, 0.0)
    twin = replace(case, methods=METHODS | {"twin": METHOD | {"settings": LINEAR | {"modes": 1}}})
    first = fits.of(recipe(twin, "ssmlearn_2", {"modes": 1}))
    assert fits.of(recipe(twin, "twin", {})) is first and first.outcome == Outcome.OK
    assert first.fits == 1 and first.dynamics > 0.0


def test_what_is_varied_is_evaluated_and_a_tolerance_needs_no_new_fit(case, monkeypatch):
    fitted = []
    fit = Fits.fit
    monkeypatch.setattr(Fits, "fit", lambda self, how: fitted.append(how) or fit(self, how))
    dataset = made(
        case, ssmlearn_2=[(["rtol"], [1e-4]), (["thin"], [2])], outside=[(["rtol"], [1e-2])]
    )
    assert [how.thin for how in fitted] == [2]
    varied_ones = dataset.isel(setting=dataset["varied"].values != "as configured")
    assert varied_ones["value"].values.tolist() == ["0.0001", "2", "0.01"]
    # The model is exact: of forced runs it misses what the full order's own steps miss, and more
    # where it is integrated loosely.
    errors = varied_ones["error"].values
    assert (errors[:2] < 0.1).all() and (errors[2] > errors[0]).all()
    assert (varied_ones["calls"].values == 1).all()
    assert varied_ones["mapping_seconds"].values.tolist()[0] == 3.0


def test_shares_of_the_training_decay(case):
    fits = Fits(case, 1, 0.0)
    half = fits.of(recipe(case, "ssmlearn_2", {"periods": two_dofs.PERIODS // 2}))
    assert half.data == pytest.approx(0.5)
    assert fits.of(recipe(case, "ssmlearn_2", {"thin": 3})).data == 1.0
    (whole,), (thin,) = (
        fits.motion(recipe(case, "ssmlearn_2", changes))[0].trajectories
        for changes in ({}, {"thin": 3, "periods": 1})
    )
    assert len(thin.time) == -(-two_dofs.SAMPLES // 3) and thin.time[1] == whole.time[3]


def test_changes_of_the_start_and_of_the_data_reach_the_start(case):
    how = recipe(case, "later", {"start.modes": 1, "thin": 2, "order": 5})
    assert how.settings == {"order": 5} and how.thin == how.start.thin == 2
    assert how.start.settings == LINEAR | {"modes": 1} and how.start.start is None


def test_a_reference_that_stopped_is_no_verdict(case):
    stopped = case.full_order["test"].assign(outcome=((), "no_convergence"))
    stopped["outcome"].attrs = case.full_order["test"]["outcome"].attrs
    lost = replace(case, full_order={**case.full_order, "test": stopped})
    fit = Fits(lost, 1, 0.0).of(recipe(lost, "ssmlearn_2", {"modes": 1}))
    study, integrator = studies.study("cost", SETTINGS), Integrator(**two_dof_case.INTEGRATOR)
    found = {
        name: cost_reduced.measured(study, lost, fit, name, integrator).outcome
        for name in QUESTIONS
    }
    assert found.pop("decay") == Outcome.REFERENCE_FAILED
    assert Outcome.REFERENCE_FAILED not in found.values()
