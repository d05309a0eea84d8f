"""A training does not depend on rounding: noise far below what is known of the data, or of the
numbers it computes with, is no larger in what it learns.
"""

from dataclasses import fields, replace
from typing import get_args

import numpy as np
import pytest

from vibrom.config import plugs
from vibrom.latent.training import OptimiserName
from vibrom.methods import method_from_settings
from vibrom.models.measures import nmte_percent
from vibrom.models.rollout import Integrator, rollout
from vibrom.models.training import Training

pytestmark = pytest.mark.usefixtures("one_thread")

SETTINGS = {
    name: {item.name for item in fields(method_from_settings(name, {}))}
    for name in plugs.names("methods")
}
TRAINED = [name for name, known in SETTINGS.items() if "optimiser" in known]


def noisy(beam, size, seed=0):
    """The training data, every number of them changed by `size` times itself, at random."""
    rng, item = np.random.default_rng(seed), beam.trajectory

    def changed(values):
        return values * (1.0 + size * rng.standard_normal(values.shape))

    parts = {name: changed(getattr(item, name)) for name in ("displacement", "velocity")}
    item = replace(item, acceleration=changed(item.acceleration), **parts)
    return Training((item,), beam.structure, seed=0)


@pytest.mark.parametrize("optimiser", get_args(OptimiserName))
@pytest.mark.parametrize("name", TRAINED)
def test_in_double_precision_no_weight_changes(beam, name, optimiser):
    """Noise of 1e-13 in the data changes no weight by more than 1e-8 of the largest.

    So for fifty epochs: longer at the highest learning rate, any training amplifies a difference
    exponentially, however small it is.
    """
    settings = {"precision": "float64", "optimiser": optimiser, "epochs": 50}
    one, two = (
        method_from_settings(name, settings).fit(noisy(beam, size)).weights for size in (0.0, 1e-13)
    )
    assert np.abs(one - two).max() <= 1e-8 * np.abs(one).max()


@pytest.mark.parametrize("name", TRAINED)
def test_in_default_precision_no_prediction_changes(beam, name):
    """Noise of 1e-9, below single precision, changes the decay error by less than 5 %."""
    errors = []
    for seed, size in enumerate((0.0, 1e-9, 1e-9)):
        rom, true = method_from_settings(name, {}).learn(noisy(beam, size, seed)), beam.trajectory
        run = rollout(rom, rom.encode(true.state[:1]), true.time[None], Integrator())
        errors.append(nmte_percent(true.displacement, rom.displacement(run.reduced[0])))
    assert np.ptp(errors) < 0.05 * np.median(errors), errors
