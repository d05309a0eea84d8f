"""Motions that are decoded to a scratch file, and files that are open only while they are read,
against the same as arrays.
"""

import time

import numpy as np
import psutil
import pytest
import two_dofs
import xarray as xr

from vibrom.artefacts.data import open_dataset, save_dataset
from vibrom.models import samples, scratch
from vibrom.models.decoded import decoded
from vibrom.models.measures import distance, nmte_percent
from vibrom.models.model import Watch
from vibrom.report.collection import Collection

RNG = np.random.default_rng(5)
SLICES = {
    "rows": np.s_[3:20],
    "every third": np.s_[::3],
    "a row": np.s_[7],
    "the last": np.s_[-1],
    "columns": np.s_[:, [4, 1]],
    "some of both": np.s_[2:30:5, 1:3],
    "a column": np.s_[:, -1],
    "rows that are true": np.arange(40) % 3 == 1,
    "all": np.s_[:, :],
}


class Linear:
    """q = z A, and how many rows were decoded each time."""

    size, matrix = 5, RNG.standard_normal((2, 5))

    def __init__(self):
        self.rows = []

    def decoded(self, coordinates, dofs=None):
        self.rows.append(len(coordinates))
        return coordinates @ (self.matrix if dofs is None else self.matrix[:, dofs])


@pytest.mark.parametrize("part", SLICES.values(), ids=SLICES)
def test_a_slice_of_what_is_decoded_to_a_file_is_that_of_an_array(part, monkeypatch):
    z, model = RNG.standard_normal((2, 40, 2)), Linear()
    whole, seconds = decoded(model, z)
    assert isinstance(whole, np.ndarray) and whole.shape == (2, 40, 5) and seconds > 0.0
    monkeypatch.setattr(samples, "BLOCK", 8 * 5 * 4)
    model.rows = []
    lazy, _ = decoded(model, z)
    assert isinstance(lazy, xr.Variable) and not lazy._in_memory
    for run in range(2):
        # The product of a few rows may add up in another order.
        np.testing.assert_allclose(lazy[run][part].values, whole[run][part], rtol=1e-13, atol=1e-15)
    assert model.rows == [4] * 20  # each once, however often it is read
    some, _ = decoded(model, z, np.array([4, 1]))
    np.testing.assert_allclose(some, whole[:, :, [4, 1]], rtol=1e-13, atol=1e-15)


def test_the_time_of_an_answer_is_without_that_of_writing(monkeypatch):
    """Of the full order's steps, and of decoding; a file takes 50 ms a block here."""
    held, append = [], scratch.OnScratch.append

    def slow(self, run, rows):
        time.sleep(0.05)
        held.append(len(rows))
        append(self, run, rows)

    monkeypatch.setattr(scratch.OnScratch, "append", slow)
    monkeypatch.setattr(samples, "BLOCK", 100)
    model = two_dofs.full_order()
    watch = Watch(model.period * np.arange(51) / 50)
    assert decoded(Linear(), np.ones((1, 10, 2)))[1] < 0.05 < 0.05 * len(held)
    held.clear()
    motion = model.motion(np.ones((1, 4)), None, watch)
    assert isinstance(motion.displacement[0], xr.Variable) and held
    assert motion.seconds < 0.05


@pytest.fixture
def stored(tmp_path, monkeypatch):
    """A decay on disk, lazily and whole."""
    path = tmp_path / "record.nc"
    save_dataset(two_dofs.record(), path)
    monkeypatch.setattr("vibrom.artefacts.on_disk.LARGE", 1000)
    return path, open_dataset(path, "trajectory")


@pytest.mark.parametrize("part", SLICES.values(), ids=SLICES)
def test_a_slice_of_a_file_is_that_of_the_array(stored, part):
    path, whole = stored
    lazy = (
        open_dataset(path, "trajectory", lazy=True).isel(time=slice(40)).isel(dof=[0, 1, 0, 1, 0])
    )
    assert not lazy["velocity"].variable._in_memory and lazy["probe"].variable._in_memory
    found = lazy["velocity"].variable[part].values
    np.testing.assert_array_equal(found, whole["velocity"].values[:40, [0, 1, 0, 1, 0]][part])


def test_a_file_is_open_only_while_it_is_read(stored):
    """HDF5 does not survive a third opening of a file with text after one of two was closed."""
    path, whole = stored
    first, second = (open_dataset(path, "trajectory", lazy=True) for _ in range(2))
    for lazy in (first, second):
        np.testing.assert_array_equal(lazy["displacement"], whole["displacement"])
    assert str(path) not in [one.path for one in psutil.Process().open_files()]
    del second
    open_dataset(path, "trajectory", lazy=True)
    assert first.identical(whole)


def test_a_collection_holds_nothing_that_grows_with_a_motion(tmp_path, monkeypatch):
    """But reads it when it is asked for, as it was; what is not what was written is refused."""
    path = tmp_path / "two/full_order/test.nc"
    path.parent.mkdir(parents=True)
    save_dataset(two_dofs.record().assign_attrs(role="test"), path)
    monkeypatch.setattr("vibrom.report.collection.LARGE", 1000)
    (key,) = Collection.at([str(path)]).loaders
    found = Collection.at([str(path)]).find(*key[:2], key.name)
    held = {name: one for name, one in found.variables.items() if one._in_memory}
    assert all(one.nbytes <= 1000 for name, one in held.items() if name not in found.dims)
    assert {"displacement", "velocity"} <= found.variables.keys() - held.keys()
    assert found.identical(open_dataset(path, "trajectory"))
    assert found.encoding["source"] == str(path)


def test_errors_in_blocks_are_those_of_whole_motions(monkeypatch):
    truth, model = RNG.standard_normal((2, 50, 3))
    wanted = np.linalg.norm(truth - model, axis=1)
    percent = 100.0 * wanted.mean() / np.linalg.norm(truth, axis=1).max()
    for block in (samples.BLOCK, 8 * 3 * 7):
        monkeypatch.setattr(samples, "BLOCK", block)
        np.testing.assert_array_equal(distance(truth, model), wanted)
        assert nmte_percent(truth, model) == percent
