"""What every experiment promises, whichever are in the folder: it evaluates the full order and
reduced models in the same words, and an exact model is scored as exact.
"""

import dataclasses

import numpy as np
import pytest
import two_dofs

from vibrom.artefacts.outcome import Outcome
from vibrom.config import plugs
from vibrom.experiments import experiment, plug

# Settings without a default, which a scene gives.
SCENE = {"forcing": 0.05, "frequency": 1.0}
# A score that is an error, in percent: the full order loses (omega h)^2/12 = 2e-5 of its frequency,
# which over twelve periods, or at resonance, is 2e-3 of a displacement.
SMALL = 0.5


def question(name):
    """The experiment, its periods few enough for a test."""
    fields = {item.name: item for item in dataclasses.fields(plug(name))}
    settings = {
        key: SCENE[key] for key, item in fields.items() if item.default is dataclasses.MISSING
    }
    return experiment(name, settings | ({"frequencies": 5} if "frequencies" in fields else {}))


def answers(model, names=None):
    """The model's answers by name, each read by those that come after it."""
    found, waiting = {}, list(names or plugs.names("experiments"))
    while waiting:
        ready = [
            name for name in waiting if not set(question(name).reads) & (set(waiting) - {name})
        ]
        assert ready, f"experiments read one another in a circle: {waiting}"
        for name in ready:
            found[name] = question(name).ask(model, two_dofs.given(**found))
            waiting.remove(name)
    return found


@pytest.fixture(scope="module")
def of_reduced():
    """Answers of the exact reduced model."""
    return answers(two_dofs.reduced())


@pytest.fixture(scope="module")
def of_full_order(of_reduced):
    """Answers of the full order; what is not evaluated of it is read from the other model."""
    model, found = two_dofs.full_order(), {}
    names = [name for name in plugs.names("experiments") if question(name).of_full_order]
    for name in sorted(names, key=lambda name: len(question(name).reads)):
        found[name] = question(name).ask(model, two_dofs.given(**(of_reduced | found)))
    return found


def truth_of(name, of_full_order):
    """What the answer is compared with."""
    against = question(name).truth
    return two_dofs.record() if against == "test" else of_full_order.get(against)


@pytest.mark.parametrize("name", plugs.names("experiments"))
def test_answers_carry_an_outcome_units_and_every_probe(name, of_reduced, of_full_order):
    for found in [of_reduced, *([of_full_order] if name in of_full_order else [])]:
        answer = found[name]
        assert {"outcome", "failed_at", "seconds"} <= set(answer.variables)
        assert {Outcome(word) for word in np.ravel(answer["outcome"].values)} == {Outcome.OK}
        for variable in answer.variables.values():
            assert variable.attrs["units"] and variable.attrs["long_name"]
        if "probe" in answer.dims:
            assert answer["probe"].values.tolist() == ["one", "two"]


@pytest.mark.parametrize("name", plugs.names("experiments"))
def test_an_exact_model_is_scored_as_exact(name, of_reduced, of_full_order):
    """Errors are in percent of a motion of the same kind; other scores are finite."""
    asked = question(name)
    scores = asked.score(of_reduced[name], truth_of(name, of_full_order))
    assert set(scores) == set(asked.scores) and np.isfinite(list(scores.values())).all()
    for score, value in scores.items():
        if asked.scores[score] == "percent":
            assert abs(value) < SMALL, (score, value)


@pytest.mark.parametrize("name", plugs.names("experiments"))
def test_both_kinds_of_model_answer_alike(name, of_reduced, of_full_order):
    """The same variables, but for reduced coordinates and the work balance, and the same values
    within the errors of the time steps.
    """
    if name not in of_full_order or not question(name).of_model:
        return
    one, other = of_reduced[name], of_full_order[name]
    only = {"reduced", "encoded", "range_ratio", "balance"}
    assert set(one.data_vars) - only == set(other.data_vars) - only
    for variable in ("displacement", "last_displacement", "amplitude", "imaginary"):
        if variable in other:
            scale = np.abs(other[variable].values).max()
            difference = np.abs(one[variable].values - other[variable].values).max()
            assert difference < 0.01 * SMALL * scale, variable


@pytest.mark.parametrize("name", plugs.names("experiments"))
def test_the_brief_form_asks_the_same_question(name, of_reduced):
    """It compiles what the long one needs, so that what is timed is the computation."""
    short = question(name).brief()
    assert type(short) is type(question(name))
    answer = short.ask(two_dofs.reduced(), two_dofs.given(**of_reduced))
    assert set(answer.variables) == set(of_reduced[name].variables)


def test_a_model_that_is_wrong_is_scored_as_wrong(of_full_order):
    """A frequency that is five percent off."""
    exact = two_dofs.reduced()
    wrong = dataclasses.replace(
        exact, rom=dataclasses.replace(exact.rom, dynamics=1.05 * exact.rom.dynamics)
    )
    for name in ("decay", "forced", "frc"):
        asked = question(name)
        answer = asked.ask(wrong, two_dofs.given())
        scores = asked.score(answer, truth_of(name, of_full_order))
        errors = [value for score, value in scores.items() if asked.scores[score] == "percent"]
        assert max(map(abs, errors)) > 2.0
