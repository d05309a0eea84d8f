"""What drawings say to those who cannot see them: numbers by hand, or of the artefacts."""

import re

import numpy as np
import pytest
import studies
from test_robustness import NOBODY, run

from vibrom.artefacts.data import variable
from vibrom.report.collection import Collection, Key, at_probe
from vibrom.report.columns import number
from vibrom.report.figures import (
    ablation,
    final_shapes,
    release_states,
    robustness_energy,
    robustness_map,
    trajectories,
    trust,
)
from vibrom.report.scores import Scores


@pytest.fixture(scope="module")
def robust():
    """Of two seeds one with three failures among six points of the map."""
    return run(
        seed_0=lambda: studies.robustness(0, 3, studies.TRUTH, np.nan),
        seed_1=lambda: studies.robustness(1, 0, studies.TRUTH, 2.0),
    )


def test_failures_of_the_map_are_counted(robust):
    words = robustness_map.seen(robust, NOBODY, "folding")
    assert "SPLIT, none: 3 of 12 failed." in words and "SPLIT, bounded: 0 of 12 failed." in words


def test_energies_are_those_at_the_end(robust):
    words = robustness_energy.seen(robust, NOBODY, "folding")
    chosen = studies.robustness(1, 0, studies.TRUTH, 2.0).isel(integrator=0).sel(guard="none")
    last = chosen["energy"].values[:, -1]
    most = number(float(last[np.isfinite(last)].max()), 2)
    lasted = f"{np.isfinite(last).sum()} of {len(last)} lasted"
    assert f"SPLIT, none: {lasted}, at most {most} J left." in words


def test_an_effect_has_its_error_or_the_reason():
    key = Key("small", "full_order", None, "ablation")
    words = ablation.seen(Collection({key: studies.ablation}), NOBODY, "small")
    assert "Without damping: decay NMTE 16.0 %." in words and "nothing" not in words
    assert "Without elasticity: needed by modal load, inertia." in words


def test_states_and_decays_are_those_of_the_artefacts(real):
    states, decays = release_states.seen(real, NOBODY), trajectories.seen(real, NOBODY)
    for scene in real.scenes:
        train = at_probe(real.find(scene, "full_order", "train"), "probe_displacement")
        ends = f"{scene}, train: from {number(train[0], 3)} m"
        assert re.search(re.escape(ends) + rf", after .* at {number(train[-1], 2)} m\.", decays)
        release = real.find(scene, "full_order", "release")["displacement"].sel(role="test")
        structure = real.find(scene, "full_order", "structure")
        tip = float(release.values[int(at_probe(structure, "probe_dof", "tip"))])
        assert f"tip at {tip:.4f} m" in states


def test_a_shape_is_as_far_off_as_its_artefact_says(real):
    found = real.find("small", "modal_projection", "forced")
    true = found["final_shape_true"].values
    off = 100.0 * np.linalg.norm(found["final_shape"].values - true) / np.linalg.norm(true)
    said = f"Modal projection: {number(off, 2)} % from the full order."
    assert said in final_shapes.seen(real, Scores.of(real), "small")


def test_trust_is_that_of_the_least_trusted_seed(real):
    key = Key("small", "full_order", None, "trust")
    study = real.find(*key[:2], "trust")
    mine = study["model"].values == "split"
    reach = np.linspace(0.2, 0.4, mine.sum())
    changed = study["trusted_displacement"].values.copy()
    changed[mine] = reach
    made = study.assign(trusted_displacement=variable("fit", changed, "m", "trusted"))
    words = trust.seen(Collection({**real.loaders, key: lambda: made}), NOBODY)
    assert "small, SPLIT: trusted up to 0.200 m." in words
