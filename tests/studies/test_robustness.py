"""How robust a fitted model is: what is evaluated of which pair, what is read, and what a model has
not.
"""

import json
from dataclasses import dataclass, replace

import numpy as np
import pytest
import two_dof_case
import two_dofs

from vibrom import studies
from vibrom.artefacts.outcome import Outcome
from vibrom.models.rollout import Integrator
from vibrom.models.rom import Rom, stored
from vibrom.models.training import MethodError
from vibrom.studies import Fitted
from vibrom.studies.parts import grid, robustness_model

SETTINGS = {
    "guards": {
        "none": {},
        "bounded": {"extrapolation": "linear"},
        "dissipative": {"dissipative": 3},
    },
    "integrators": {
        "tight": two_dof_case.INTEGRATOR,
        "loose": {"rtol": 1e-3, "atol": 1e-6},
        "implicit": {"method": "gauss", "steps": 20},
    },
    "forcing": [0.5, 1.0],
    "frequency": {"lowest": 0.8, "highest": 1.2, "count": 3},
    "periods": 5,
    "releases": 2,
    "beyond": 0.01,
}
RUNS = 2 * 3 + 2 * 2


@pytest.fixture(autouse=True)
def no_elements(monkeypatch):
    """The full order is that of two masses; no mesh is behind it."""
    monkeypatch.setattr(
        robustness_model.FullOrder, "of_scene", lambda scene, known: two_dofs.full_order()
    )


def made(case, **changes):
    """The dataset of a fitted model."""
    return studies.study("robustness", SETTINGS | changes).job("model", case)


def exact(**changes):
    """The exact model of the run."""
    return two_dof_case.case(two_dof_case.fit(two_dofs.rom()), **changes)


def rollouts(monkeypatch):
    """(rom, integrator) of every grid of runs that is evaluated."""
    found, ended = [], grid.ended

    def counted(model, *given):
        found.append((model.rom, model.integrator))
        return ended(model, *given)

    monkeypatch.setattr(grid, "ended", counted)
    return found


def test_pairs_without_the_first_guard_or_integrator_are_not_run():
    outcome = made(exact())["outcome"]
    assert outcome.dims == ("guard", "integrator", "run") and outcome.sizes["run"] == RUNS
    for guard in SETTINGS["guards"]:
        for integrator in SETTINGS["integrators"]:
            words = set(outcome.sel(guard=guard, integrator=integrator).values)
            if guard == "none" or integrator == "tight":
                assert Outcome.NOT_RUN not in words
            else:
                assert words == {Outcome.NOT_RUN}


def test_of_the_run_s_own_model_and_integrator_the_answers_are_read():
    """Those that the run is said to have given differ from those that are right."""
    dataset = made(exact())
    own, loose = (dataset.sel(guard="none", integrator=name) for name in ("tight", "loose"))
    assert float(own["decay_nmte"]) == float(own["forced_nmte"]) == float(own["real_part"]) == 7.0
    assert (own["frc_amplitude"].values == 7.0).all() and set(own["outcome"].values) == {"ok"}
    assert float(loose["decay_nmte"]) < 0.5 and float(loose["forced_nmte"]) < 0.5
    assert float(loose["real_part"]) == pytest.approx(-two_dofs.DAMPING / 2, rel=1e-6)
    truth = two_dof_case.full_order()["frc"]["amplitude"].values[0]
    np.testing.assert_allclose(loose["frc_amplitude"], truth, rtol=2e-3)


def test_with_another_integrator_than_the_run_s_nothing_is_read():
    other = made(exact(integrator={"rtol": 1e-6, "atol": 1e-8}))
    assert float(other["decay_nmte"].sel(guard="none", integrator="tight")) < 0.5


def test_guards_that_make_the_same_model_are_evaluated_once(monkeypatch):
    found = rollouts(monkeypatch)
    dataset = made(exact(), guards={"none": {}, "same": {"extrapolation": "none"}})
    assert len(found) == len(SETTINGS["integrators"])
    first, second = (dataset.sel(guard=name, integrator="tight") for name in ("none", "same"))
    for name in ("outcome", "range_ratio", "energy", "frc_amplitude"):
        np.testing.assert_array_equal(first[name].values, second[name].values)


def test_the_run_s_answers_are_those_of_the_guard_that_its_model_has():
    """A model that was fitted with a guard loses it in the first column."""
    rom = replace(two_dofs.rom(), extrapolation="linear")
    dataset = made(two_dof_case.case(two_dof_case.fit(rom))).sel(integrator="tight")
    assert float(dataset["decay_nmte"].sel(guard="none")) < 0.5
    assert float(dataset["decay_nmte"].sel(guard="bounded")) == 7.0


def test_a_guard_that_a_model_cannot_have_is_unsupported_and_says_why():
    """A dissipative fit is for one reduced position, and this model has two."""
    dataset = made(exact())
    lost = dataset.sel(guard="dissipative", integrator="tight")
    assert set(lost["outcome"].values) == set(lost["frc_outcome"].values) == {Outcome.UNSUPPORTED}
    assert np.isnan(lost["energy"]).all() and np.isnan(float(lost["decay_nmte"]))
    assert "has 2" in json.loads(dataset.attrs["reasons"])["dissipative"]


@dataclass(frozen=True)
class Own(Rom):
    """The example of a method in docs/: four functions, and no compiled field."""

    modes: np.ndarray = stored("kg^(-1/2)", "modes", "mode", "dof")

    def encode(self, x):
        q, v = np.split(x, 2, axis=-1)
        back = self.modes @ two_dofs.MASS
        return np.concatenate([q @ back.T, v @ back.T], axis=-1)

    def decode(self, z):
        q, v = np.split(z, 2, axis=-1)
        return np.concatenate([q @ self.modes, v @ self.modes], axis=-1)

    def drift(self, z):
        q, v = np.split(z, 2, axis=-1)
        return np.concatenate([v, -two_dofs.SQUARES * q - two_dofs.DAMPING * v], axis=-1)

    def force_map(self, z, p):
        push = self.modes @ p
        return np.broadcast_to(np.concatenate([0 * push, push]), z.shape)


def test_a_model_of_four_functions_gets_through(monkeypatch):
    """The guards that it cannot have are an outcome of their cells; the others have numbers."""
    reach = np.concatenate([np.full(2, 10.0), 10.0 * two_dofs.FREQUENCIES])
    own = Own(reach, two_dofs.MODES)
    monkeypatch.setattr(robustness_model, "rom_from_dataset", lambda record: own)
    dataset = made(exact())
    for integrator in SETTINGS["integrators"]:
        words = dataset["outcome"].sel(guard="none", integrator=integrator).values
        assert set(words) == {Outcome.OK}
    assert float(dataset["decay_nmte"].sel(guard="none", integrator="implicit")) < 0.5
    for guard in ("bounded", "dissipative"):
        words = dataset["outcome"].sel(guard=guard, integrator="tight").values
        assert set(words) == {Outcome.UNSUPPORTED}
    assert "no guards" in json.loads(dataset.attrs["reasons"])["bounded"]


def test_an_integrator_that_a_model_cannot_have_is_unsupported_and_says_why(monkeypatch):
    ended = grid.ended

    def refuses(model, *given):
        if model.integrator.method == "gauss":
            raise MethodError("no implicit steps for this model")
        return ended(model, *given)

    monkeypatch.setattr(grid, "ended", refuses)
    dataset = made(exact())
    words = dataset["outcome"].sel(guard="none", integrator="implicit").values
    assert set(words) == {Outcome.UNSUPPORTED}
    assert json.loads(dataset.attrs["reasons"])["implicit"] == "no implicit steps for this model"
    assert set(dataset["outcome"].sel(guard="none", integrator="loose").values) == {Outcome.OK}


def test_a_model_that_was_never_fitted_has_its_word_everywhere():
    unfit = two_dof_case.fit(two_dofs.rom(), outcome="training_diverged")
    case = two_dof_case.case(unfit)
    case = replace(case, fitted=(Fitted(unfit, two_dof_case.answers()),))
    outcome = made(case)["outcome"]
    assert set(outcome.sel(integrator="tight").values.ravel()) == {Outcome.TRAINING_DIVERGED}


def test_an_answer_that_the_run_does_not_have_has_its_word():
    answers = two_dof_case.answers()
    never = answers["frc"].drop_vars("amplitude").assign_attrs(answered=0)
    answers["frc"] = never.assign(outcome=((), "skipped", never["outcome"].attrs))
    case = exact()
    case = replace(case, fitted=(replace(case.fitted[0], answers=answers),))
    own = made(case).sel(guard="none", integrator="tight")
    assert set(own["frc_outcome"].values) == {"skipped"} and np.isnan(own["frc_amplitude"]).all()


def test_the_integrators_of_settings_are_those_of_the_run():
    """Otherwise nothing would be read: 1e-8 in both, whole defaults in one."""
    made_of = studies.study("robustness", SETTINGS)
    assert made_of.integrators["tight"] == Integrator(**two_dof_case.INTEGRATOR)
