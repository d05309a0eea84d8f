"""The example of a method in docs/, four functions and no compiled code, in every experiment, with
every integrator and every guard.
"""

import dataclasses
import pkgutil
from typing import get_args

import numpy as np
import pytest
import two_dofs
from scipy.sparse import csr_matrix

from vibrom.artefacts.outcome import Outcome
from vibrom.config import plugs
from vibrom.experiments import experiment, plug
from vibrom.methods import method_from_settings
from vibrom.models.recorded import trajectory
from vibrom.models.reduced import Reduced
from vibrom.models.rollout import Integrator
from vibrom.models.rom import Extrapolation, Guards
from vibrom.models.training import Structure, Training, Unsupported
from vibrom.solvers.periodic.carried import swept, swings
from vibrom.solvers.reduced import steppers

STEPPERS = [module.name for module in pkgutil.iter_modules(steppers.__path__)]


@pytest.fixture(scope="module")
def training():
    damping = two_dofs.DAMPING * two_dofs.MASS
    operators = (csr_matrix(part) for part in (two_dofs.MASS, damping, two_dofs.STIFFNESS))
    structure = Structure(*operators, two_dofs.MODES, two_dofs.FREQUENCIES)
    return Training((trajectory(two_dofs.record()),), structure)


@pytest.fixture(scope="module")
def rom(training, example):
    return method_from_settings(example, {}).learn(training)


def question(name):
    """The experiment, with the settings that a scene gives, and a small forcing."""
    needed = [
        item.name
        for item in dataclasses.fields(plug(name))
        if item.default is dataclasses.MISSING or item.name == "forcing"
    ]
    return experiment(name, dict.fromkeys(needed, 0.05)).brief()


@pytest.mark.parametrize("integrator", STEPPERS)
def test_every_experiment_has_an_answer(rom, integrator):
    model = Reduced(
        rom, two_dofs.LOAD, np.array([0, 1]), two_dofs.DAMPED, Integrator(method=integrator)
    )
    waiting, found = list(plugs.names("experiments")), {}
    while waiting:
        name = next(name for name in waiting if not set(question(name).reads) & set(waiting))
        found[name] = question(name).ask(model, two_dofs.given(**found))
        waiting.remove(name)
        endings = {Outcome(word) for word in np.ravel(found[name]["outcome"].values)}
        assert all(ending.has_value for ending in endings), name


def test_guards_that_it_lacks_are_unsupported(rom, training):
    assert rom.guarded(Guards(), training) is rom
    for guards in (*map(Guards, get_args(Extrapolation)[1:]), Guards(dissipative=5)):
        with pytest.raises(Unsupported, match="has no guards"):
            rom.guarded(guards, training)


def test_a_motion_that_is_lost_at_once_has_no_value_at_any_probe(rom):
    model = Reduced(rom, two_dofs.LOAD, np.array([0, 1]), two_dofs.DAMPED, Integrator())
    flow, frequencies = model.return_map(), two_dofs.DAMPED * np.array([1.0, 1.1])
    lost, kept = (
        swings(flow, swept(flow, frequencies, forcing, 2), frequencies, forcing)
        for forcing in (100.0, 1e-3)
    )
    assert kept.shape == lost.shape and kept.shape[:2] == (2, 2)
    assert np.isfinite(kept).all() and np.isnan(lost).all()
