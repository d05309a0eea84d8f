"""Samples that are taken a block at a time give what they give at once."""

import numpy as np
import pytest
import two_dofs
import xarray as xr

from vibrom.artefacts.data import open_dataset, save_dataset
from vibrom.latent import coordinates
from vibrom.methods.modal_projection import ModalProjection
from vibrom.methods.ssmlearn import SsmLearn
from vibrom.models import samples
from vibrom.models.recorded import structure, trajectories
from vibrom.models.samples import Samples, directions
from vibrom.models.training import Training

RNG = np.random.default_rng(0)
BLOCK = 2000  # bytes: of a hundred samples of a few displacements, some blocks


@pytest.fixture
def small(monkeypatch):
    monkeypatch.setattr(samples, "BLOCK", BLOCK)


def motions():
    """Two of them, position beside velocity, (40 and 70, 3 + 4)."""
    return [(RNG.standard_normal((m, 3)), RNG.standard_normal((m, 4))) for m in (40, 70)]


def test_blocks_and_columns_are_the_matrix(small):
    parts = motions()
    matrix, given = np.vstack([np.hstack(part) for part in parts]), Samples(tuple(parts))
    blocks = list(given.blocks())
    assert given.shape == matrix.shape and len(blocks) > 3
    assert max(block.nbytes for block in blocks) <= BLOCK
    np.testing.assert_array_equal(np.vstack(blocks), matrix)
    found = np.full_like(matrix, np.nan)
    for some, block in given.columns():
        found[:, some] = block
    np.testing.assert_array_equal(found, matrix)
    right = RNG.standard_normal((7, 2))
    np.testing.assert_allclose(given @ right, matrix @ right, rtol=1e-13, atol=1e-14)
    np.testing.assert_allclose(given.norm(), np.linalg.norm(matrix), rtol=1e-14)
    thin = np.vstack([np.hstack(part)[::3] for part in parts])
    np.testing.assert_array_equal(np.vstack(list(given.thinned(3).blocks())), thin)
    assert given.all(np.isfinite) and not given.all(lambda block: block > 0)


def test_directions_of_blocks_are_those_of_all_rows(monkeypatch):
    """Values from 1 to 1e-9: what is left out beyond SPARE has no say in the first ones."""
    monkeypatch.setattr(samples, "SPARE", 8)
    left, right = (np.linalg.qr(RNG.standard_normal((n, 20)))[0] for n in (300, 50))
    values = np.logspace(0, -9, 20)
    rows = (left * values) @ right.T
    found, vectors = directions(iter(np.array_split(rows, 13)), 4)
    np.testing.assert_allclose(found[:4], values[:4], rtol=1e-12)
    # Rounding turns a direction by eps over its share of the largest value.
    cosines = np.abs(np.sum(vectors[:4] * right.T[:4], axis=1))
    np.testing.assert_allclose(cosines, 1.0, rtol=1e-10)


@pytest.fixture
def lazy(tmp_path, monkeypatch):
    """The record of two masses, on disk."""
    monkeypatch.setattr("vibrom.artefacts.on_disk.LARGE", 1000)
    save_dataset(two_dofs.record(), tmp_path / "record.nc")
    return trajectories(open_dataset(tmp_path / "record.nc", "trajectory", lazy=True), lazy=True)


def test_a_lazy_record_is_read_where_it_is_sliced(lazy, small):
    (whole,) = trajectories(two_dofs.record())
    (record,) = lazy
    assert isinstance(record.displacement, xr.Variable)
    assert not record.displacement._in_memory
    np.testing.assert_array_equal(
        np.vstack(list(Samples(((record.velocity,),)).blocks())), whole.velocity
    )
    assert not record.velocity._in_memory


@pytest.mark.parametrize(
    "method",
    [ModalProjection(modes=2, order=1), SsmLearn(), SsmLearn(tangent="data")],
    ids=["modal_projection", "ssmlearn", "ssmlearn of data"],
)
def test_a_fit_to_a_file_in_blocks_is_the_fit_to_arrays(lazy, monkeypatch, method):
    known, model = structure(two_dofs.structure()), []
    for given, block in ((trajectories(two_dofs.record()), samples.BLOCK), (lazy, BLOCK)):
        monkeypatch.setattr(samples, "BLOCK", block)
        model.append(method.learn(Training(given, known)))
    for name in ("encoder", "scale", "decoder", "dynamics"):
        whole, blocks = (getattr(one, name) for one in model)
        # Sums in another order, and least squares of a condition of some thousands.
        np.testing.assert_allclose(blocks, whole, rtol=1e-9, atol=1e-11 * np.abs(whole).max())


@pytest.mark.parametrize("modes", [0, 1])
def test_coordinates_of_a_file_in_blocks_are_those_of_arrays(lazy, monkeypatch, modes):
    known, found = structure(two_dofs.structure()), []
    for given, block in ((trajectories(two_dofs.record()), samples.BLOCK), (lazy, BLOCK)):
        monkeypatch.setattr(samples, "BLOCK", block)
        chosen = coordinates.choose(
            Training(given, known), rank=2, modes=modes, scaled=True, time_scale="none"
        )
        found.append(chosen.stack(given, 3))
    np.testing.assert_allclose(found[1], found[0], rtol=1e-10, atol=1e-12)
