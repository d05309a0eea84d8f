"""A fit: its checkpoints, its times, and what is stored where there is no model."""

import shutil

import numpy as np
import pytest
import xarray as xr

from vibrom.artefacts.data import open_dataset, outcome_variables
from vibrom.methods.modal_projection import ModalProjection
from vibrom.models.training import Clock, MethodError, TrainingDiverged
from vibrom.steps import fit
from vibrom.steps.fit import FileMonitor


def test_a_damaged_checkpoint_is_none(tmp_path):
    path, weights = tmp_path / "state.checkpoint", np.arange(500.0)
    FileMonitor(str(path), "fit").checkpoint({"weights": weights})
    assert np.array_equal(FileMonitor(str(path), "fit").restore()["weights"], weights)
    whole = path.read_bytes()
    torn = [whole[:length] for length in (0, 2, 100, len(whole) // 2, len(whole) - 3)]
    for place in range(0, len(whole), 29):  # of names, sizes, numbers and the digest itself
        flipped = bytearray(whole)
        flipped[place] ^= 1 << place % 8
        torn.append(bytes(flipped))
    for damaged in torn:
        path.write_bytes(damaged)
        monitor = FileMonitor(str(path), "fit")
        assert monitor.restore() is None and monitor.spent("total") == 0.0


@pytest.fixture
def now(monkeypatch):
    """The clock of fits, [s], which stands still unless a test moves it."""
    instant = [0.0]
    monkeypatch.setattr("vibrom.models.training.perf_counter", lambda: instant[0])
    return instant


def test_a_resumed_fit_counts_what_it_spent_before(tmp_path, now):
    path = str(tmp_path / "state.checkpoint")
    first = FileMonitor(path, "fit")
    first.seconds["total"] = 40.0
    first.checkpoint({})
    second = FileMonitor(path, "fit")
    with second.phase("total"):
        second.restore()
        now[0] += 2.0
    assert second.seconds["total"] == 42.0


@pytest.fixture
def folder(beam, tmp_path):
    """The artefacts that a fit reads."""
    for name in ("structure", "train"):
        shutil.copy(beam.folder / f"{name}.nc", tmp_path)
    return tmp_path


def changed(folder, change):
    """Writes train.nc again as `change` makes it."""
    train = xr.load_dataset(folder / "train.nc")
    del train.attrs["content"]  # as an outside tool would write it
    change(train).to_netcdf(folder / "train.nc", mode="w")


def run(folder, **changes):
    """(rom.nc, losses.nc) of a fit in the folder."""
    paths = {name: str(folder / f"{name}.nc") for name in ("structure", "train", "rom", "losses")}
    recipe = {
        "scene": "beam",
        "method": "own",
        "kind": "modal_projection",
        "settings": {},
        "seed": None,
        "device": "cpu",
    }
    fit.run(**paths, recipe=recipe | changes, provenance={})
    return open_dataset(paths["rom"], "rom"), open_dataset(paths["losses"], "losses")


def test_the_time_of_a_method_without_phases_is_counted(beam, folder, monkeypatch, now):
    """It is measured around the fit: a method need not mark anything."""

    def slowly(self, training, own=ModalProjection.fit):
        now[0] += 0.2
        monkeypatch.setattr(training.monitor, "phase", Clock().phase)
        return own(self, training)

    monkeypatch.setattr(ModalProjection, "fit", slowly)
    rom, losses = run(folder)
    assert float(rom["mapping_seconds"]) == 0.2 and float(rom["dynamics_seconds"]) == 0.0
    assert float(rom["data_seconds"]) == float(beam.train["seconds"]) > 0.0
    assert losses.sizes["epoch"] == 0 and rom.attrs["rom"].endswith(":PolynomialRom")


def test_a_quick_fit_counts_with_its_shortest_time(folder, monkeypatch, now):
    """Three fits, of which the second is the quickest; with a seed there is one."""
    waits = [0.2, 0.05, 0.2]

    def slowly(self, training, own=ModalProjection.fit):
        now[0] += waits.pop(0)
        return own(self, training)

    monkeypatch.setattr(ModalProjection, "fit", slowly)
    rom, _ = run(folder)
    spent = float(rom["mapping_seconds"]) + float(rom["dynamics_seconds"])
    assert spent == pytest.approx(0.05, rel=1e-12)
    waits = [0.1]
    run(folder, seed=0)
    assert not waits


def test_a_diverged_training_is_stored_as_such(folder, monkeypatch):
    def diverges(self, training):
        raise TrainingDiverged("at epoch 3")

    monkeypatch.setattr(ModalProjection, "fit", diverges)
    rom, _ = run(folder)
    assert rom["outcome"].item() == "training_diverged" and rom.attrs["reason"] == "at epoch 3"
    assert "encoder" not in rom


def test_what_stopped_before_is_said(folder):
    def stopped(train):
        ending = outcome_variables("no_convergence", 0.5)
        return train.drop_vars(list(ending)).assign(ending)

    changed(folder, stopped)
    rom, _ = run(folder)
    assert rom["outcome"].item() == "reference_failed"
    assert rom.attrs["reason"].startswith("the full-order training run stopped at 0.5 s")


def test_data_at_rest_are_one_line(folder):
    changed(folder, lambda train: train.assign(displacement=0.0 * train["displacement"]))
    with pytest.raises(MethodError, match="own in scene beam: the training data hold no motion"):
        run(folder)


@pytest.mark.parametrize("repeats", [1, 20])
def test_data_that_do_not_determine_a_model_are_an_outcome(folder, repeats):
    """Twenty samples determine twenty of 54 coefficients, repeated or not."""
    changed(folder, lambda train: train.isel(time=np.tile(np.arange(20), repeats)))
    rom, _ = run(folder, settings={"order": 9})
    assert rom["outcome"].item() == "underdetermined" and "encoder" not in rom
    assert rom.attrs["reason"] == (
        f"of 54 coefficients the {20 * repeats} samples determine 20; lower the order, or give "
        "data that differ more from one another"
    )
