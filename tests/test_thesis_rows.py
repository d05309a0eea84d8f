"""Golden numbers: the beam, its release states, and the rows of the thesis that come from no
training, in all three cases.

Release states are those of a careful reproduction (five digits); reconstruction and eigenvalues are
printed in the thesis (Tables 3.2, 3.3) and are met within 0.5 %, its decays (Table 3.4) within 4 %:
it integrated its models with a relative tolerance of 1e-3.
"""

from pathlib import Path

import numpy as np
import pytest

from vibrom.artefacts.data import open_dataset
from vibrom.config import settings
from vibrom.experiments import Given, experiment
from vibrom.methods import method_from_settings
from vibrom.models.recorded import structure, trajectory
from vibrom.models.reduced import Integrator, Reduced
from vibrom.models.training import Training
from vibrom.steps import record, release
from vibrom.steps import structure as structure_step
from vibrom.thesis import published as thesis

CONFIG = Path(__file__).parents[1] / "config"
# (probe y, tip y, tip x) [m] and phi_1' M q of the five release states.
STATES = {
    ("small", "test"): (0.049608, 0.13392, -0.01049, 0.044443),
    ("small", "train"): (0.141207, 0.37481, -0.08614, 0.124887),
    ("large", "test"): (0.141207, 0.37481, -0.08614, 0.124887),
    ("large", "train"): (0.279705, 0.69933, -0.36583, 0.237154),
    ("folding", "test"): (0.356818, 0.82249, -0.66642, 0.286417),
    ("folding", "train"): (0.377742, 0.83399, -0.78939, 0.294776),
}


@pytest.fixture(scope="module", params=["small", "large", "folding"])
def case(request, tmp_path_factory):
    folder = tmp_path_factory.mktemp(request.param)
    scene = settings.load(CONFIG).scenes[request.param].to_builtins()
    path = {name: str(folder / f"{name}.nc") for name in ("structure", "release", "train", "test")}
    scene["record"]["finer"] = 0  # no converged decay
    given = {"scene": scene, "provenance": {}}
    structure_step.run(structure=path["structure"], name=request.param, **given)
    release.run(structure=path["structure"], release=path["release"], **given)
    for role in ("train", "test"):
        known = {name: path[name] for name in ("structure", "release")}
        record.run(trajectory=path[role], role=role, **known, **given)
    kinds = {
        "structure": "structure",
        "release": "release",
        "train": "trajectory",
        "test": "trajectory",
    }
    return request.param, {name: open_dataset(path[name], kind) for name, kind in kinds.items()}


def test_release_states(case):
    name, artefacts = case
    known, probes = structure(artefacts["structure"]), artefacts["structure"]["probe_dof"]
    for role in ("train", "test"):
        q = artefacts["release"]["displacement"].sel(role=role).values
        found = [
            *q[probes.sel(probe=["probe", "tip", "tip_x"]).values],
            known.modes[0] @ (known.mass @ q),
        ]
        np.testing.assert_allclose(found, STATES[name, role], rtol=1e-3)


@pytest.mark.parametrize("method", ["modal_projection", "ssmlearn"])
def test_rows_of_the_thesis(case, method):
    name, artefacts = case
    known = structure(artefacts["structure"])
    rom = method_from_settings(method, {}).fit(
        Training((trajectory(artefacts["train"]),), structure=known)
    )
    model = Reduced.of_scene(rom, artefacts["structure"], Integrator())
    given = Given(artefacts["structure"], 200, {"test": artefacts["test"]})

    def score(question, metric):
        asked = experiment(question)
        return asked.score(asked.ask(model, given), artefacts["test"])[metric]

    assert score("reconstruction", "nmte_percent") == pytest.approx(
        thesis.percent("reconstruction", name, method)[0], rel=5e-3
    )
    assert score("decay", "nmte_percent") == pytest.approx(
        thesis.percent("decay", name, method)[0], rel=4e-2
    )
    real, imaginary = thesis.eigenvalue(name, method)
    assert score("eigenvalues", "real_per_s") == pytest.approx(real, rel=5e-3)
    assert score("eigenvalues", "imaginary_rad_per_s") == pytest.approx(imaginary, rel=5e-3)
