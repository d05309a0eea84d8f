"""The recorded test decay beside what it would be without errors of the time integration."""

import os
import tracemalloc

import numpy as np
import pytest
import two_dofs
from beam import SCENE

from vibrom.artefacts.data import label, open_dataset, save_dataset, variable
from vibrom.artefacts.stream import growing
from vibrom.methods.modal_projection import ModalProjection
from vibrom.models.full_order import FullOrder
from vibrom.models.measures import nmte_percent
from vibrom.models.recorded import differences, trajectories, trajectory
from vibrom.models.training import Training
from vibrom.solvers.full.newmark import Record as Kept
from vibrom.steps import ask, record

# What is read at a time, and what stays on disk.
SIZES = ("models.samples.BLOCK", "artefacts.identity.BLOCK", "artefacts.on_disk.LARGE")


def test_the_converged_decay_approaches_the_closed_form_with_order_four(tmp_path):
    truth, model, errors = trajectory(two_dofs.record()), two_dofs.full_order(), []
    count, every = len(truth.time), model.steps_per_period // two_dofs.SAMPLES
    for finer in (2, 4):
        path = tmp_path / f"{finer}.nc"
        with growing(path, {"time": count, "dof": 2}, "float64", 3) as file:
            for name in ("displacement", "velocity"):
                file.add(name, "1", name)
                file.write(name, 0, getattr(truth, name))
            told = record.converged(model, finer, every, count, file)
            found = file.read(record.BESIDE, 0, count)
        errors.append(nmte_percent(truth.displacement, found))
        assert float(told) == nmte_percent(found, truth.displacement)
    order = np.log2(errors[0] / errors[1])
    assert abs(order - 4.0) < 0.1


def test_only_the_test_decay_has_a_converged_one(beam, tmp_path):
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


@pytest.mark.parametrize("derivatives", ["differences", "integrator"])
def test_a_decay_that_is_written_in_chunks_is_the_one_that_is_held_in_memory(
    beam, tmp_path, monkeypatch, derivatives
):
    """Chunks of 7 steps, so that some have no sample to keep, against all steps at once."""
    monkeypatch.setattr("vibrom.solvers.full.banded_steps.chunk", lambda n, width: 7)
    known = {name: str(beam.folder / f"{name}.nc") for name in ("structure", "release")}
    path, every = str(tmp_path / "train.nc"), 9
    asked = {"periods": 1, "derivatives": derivatives}
    scene = SCENE | {"record": asked, "time": SCENE["time"] | {"every": every}}
    record.run(**known, trajectory=path, scene=scene, role="train", provenance={})
    found, model = open_dataset(path, "trajectory"), FullOrder.of_scene(scene, beam.known)
    shape = open_dataset(known["release"], "release")["displacement"].sel(role="train").values
    start = np.concatenate([shape, 0.0 * shape])[None]
    step = model.period / model.steps_per_period
    motion = model.run(start, np.array([step]), model.steps_per_period, Kept(), None)
    q, v, a = motion.displacement[0], motion.velocity[0], motion.acceleration[0]
    kept = slice(None, None, every)
    if derivatives == "differences":
        q, (v, a) = q[3:-3], differences(q, step)
    for name, values in (("displacement", q), ("velocity", v), ("acceleration", a)):
        np.testing.assert_array_equal(found[name].values, values[kept])


def test_storing_float32_halves_the_file_and_says_what_it_cost(beam, tmp_path):
    known = {name: str(beam.folder / f"{name}.nc") for name in ("structure", "release")}
    made = {}
    for stored in ("float64", "float32"):
        path = tmp_path / f"{stored}.nc"
        scene = SCENE | {"record": {"periods": 1, "stored": stored}}
        record.run(**known, trajectory=str(path), scene=scene, role="train", provenance={})
        made[stored] = open_dataset(path, "trajectory"), path.stat().st_size
    (whole, large), (rounded, small) = made.values()
    assert small < 0.6 * large
    for name in ("displacement", "velocity", "acceleration"):
        error = np.abs(rounded[name].astype(float) - whole[name]).max() / np.abs(whole[name]).max()
        # Half of the last of 24 binary digits.
        assert 0.0 < error <= 2.0**-24
        assert rounded[name].attrs["rounding"].endswith(f"to {float(error):.1e} of its largest")
        assert "rounding" not in whole[name].attrs


def peak(call) -> int:
    """Bytes that a call allocates at most, of what Python and numpy tell of."""
    tracemalloc.start()
    try:
        call()
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


def test_neither_recording_nor_fitting_nor_an_answer_holds_the_decay(beam, tmp_path, monkeypatch):
    """Blocks that are small beside 40 periods; all in memory would take the file's size, and
    several times that where copies are made.
    """
    monkeypatch.setattr("vibrom.solvers.full.banded_steps.chunk", lambda n, width: 100)
    for size_of in SIZES:
        monkeypatch.setattr(f"vibrom.{size_of}", 2**17)
    known = {name: str(beam.folder / f"{name}.nc") for name in ("structure", "release")}
    path, scene = str(tmp_path / "train.nc"), SCENE | {"record": {"periods": 40}}
    given = known | {"trajectory": path, "scene": scene, "role": "train", "provenance": {}}
    held = peak(lambda: record.run(**given))
    size = os.stat(path).st_size
    assert size > 6e6 and held < size / 3

    def fit() -> None:
        motion = trajectories(open_dataset(path, "trajectory", lazy=True), lazy=True)
        nonlocal rom
        rom = ModalProjection(order=1).learn(Training(motion, beam.structure)).to_dataset()

    rom = None

    assert peak(fit) < size / 3

    def ask_it() -> None:
        fitted = label(rom, "rom", scene="beam", method="modal_projection", reason="")
        save_dataset(
            fitted.assign(outcome=variable((), "ok", "1", "how the fit ended")), paths["rom"]
        )
        names = {"scene": "beam", "method": "modal_projection"}
        questions = {name: {} for name in ("reconstruction", "decay")}
        truth = {f"truth_{name}": path for name in questions}
        given = {"questions": questions, "names": names, "samples": 200, "provenance": {}}
        ask.run(**given, **paths, **truth, structure=known["structure"], test=path)

    monkeypatch.setattr(ask, "ENOUGH", 0.0)  # each is asked once
    paths = {name: str(tmp_path / f"{name}.nc") for name in ("rom", "reconstruction", "decay")}
    with monkeypatch.context() as patched:  # all is one block
        for size_of in SIZES:
            patched.setattr(f"vibrom.{size_of}", 2**25)
        ask_it()  # loads and compiles, too
    whole = {name: open_dataset(paths[name], name) for name in ("reconstruction", "decay")}
    assert peak(ask_it) < size / 3
    for name, wanted in whole.items():
        found = open_dataset(paths[name], name)
        assert "displacement" not in found and float(wanted["score_value"][0]) > 0.0
        for key in ("error", "encoded", "probe_displacement", "probe_true", "score_value"):
            if key in wanted:
                np.testing.assert_allclose(found[key], wanted[key], rtol=1e-10, atol=1e-13)
