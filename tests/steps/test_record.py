"""The recorded test decay beside what it would be without errors of the time integration."""

import numpy as np
import two_dofs

from vibrom.artefacts.data import open_dataset
from vibrom.models.measures import nmte_percent
from vibrom.models.recorded import trajectory
from vibrom.steps import record


def test_the_converged_decay_approaches_the_closed_form_with_order_four():
    truth = trajectory(two_dofs.record())
    errors = []
    for finer in (2, 4):
        found = record.converged(two_dofs.full_order(), finer, truth.state[0], truth.time)
        errors.append(nmte_percent(truth.displacement, found))
    order = np.log2(errors[0] / errors[1])
    assert abs(order - 4.0) < 0.1


def test_only_the_test_decay_has_a_converged_one(beam, tmp_path):
    from beam import SCENE

    assert "converged_displacement" not in beam.train
    path = str(tmp_path / "test.nc")
    known = {name: str(beam.folder / f"{name}.nc") for name in ("structure", "release")}
    scene = SCENE | {"record": {"periods": 2, "derivatives": "differences", "finer": 2}}
    record.run(**known, trajectory=path, scene=scene, role="test", provenance={})
    found = open_dataset(path, "trajectory")
    truth, own = (found[f"{name}displacement"].values for name in ("converged_", ""))
    np.testing.assert_allclose(truth[0], own[0], rtol=1e-14)
    # The steps of the scene shift the frequency by (omega h)^2/12: an angle of 1e-3 in two periods,
    # half of it on average; numerical damping adds 0.005 omega h/2 a radian: 1e-3 as well.
    assert 0.02 < float(found["converged_nmte"]) == nmte_percent(truth, own) < 0.2
