"""The contract of the artefacts: what is refused, and that nothing finished is lost."""

import errno
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
import xarray as xr

from vibrom.artefacts.data import label, open_dataset, save_dataset, scored, variable
from vibrom.artefacts.files import DataError, write


def release(value=1.0):
    dataset = xr.Dataset(
        {"displacement": variable(("role", "dof"), np.full((2, 3), value), "m", "displacement")}
    )
    return label(dataset, "release", scene="small", method="full_order")


def test_same_dataset_same_bytes(tmp_path):
    for name in ("a.nc", "b.nc"):
        save_dataset(release(), tmp_path / name, {"source_digest": "0"})
    assert (tmp_path / "a.nc").read_bytes() == (tmp_path / "b.nc").read_bytes()


def test_bare_variables_are_refused(tmp_path):
    with pytest.raises(DataError, match="no units or long_name on extra"):
        save_dataset(release().assign(extra=("dof", np.zeros(3))), tmp_path / "a.nc")
    assert list(tmp_path.iterdir()) == []


def test_missing_variables_are_refused(tmp_path):
    with pytest.raises(DataError, match="the release lacks displacement"):
        save_dataset(release().drop_vars("displacement"), tmp_path / "a.nc")


def test_truncated_file(tmp_path):
    save_dataset(release(), tmp_path / "a.nc")
    whole = (tmp_path / "a.nc").read_bytes()
    (tmp_path / "a.nc").write_bytes(whole[: len(whole) // 2])
    with pytest.raises(
        DataError, match="a.nc: not a readable netCDF file .* delete it and run again"
    ):
        open_dataset(tmp_path / "a.nc", "release")


def test_foreign_file(tmp_path):
    xr.Dataset({"x": ("t", [1.0])}).to_netcdf(tmp_path / "a.nc")
    with pytest.raises(DataError, match="kind is None, but 'release' is needed here"):
        open_dataset(tmp_path / "a.nc", "release")


def test_full_disk_leaves_the_finished_file(tmp_path, monkeypatch):
    save_dataset(release(1.0), tmp_path / "a.nc")
    before = (tmp_path / "a.nc").read_bytes()

    def full(*args, **kwargs):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(xr.Dataset, "to_netcdf", full)
    with pytest.raises(
        DataError, match="a.nc: cannot be written .*No space left on device.* free space"
    ):
        save_dataset(release(2.0), tmp_path / "a.nc")
    assert (tmp_path / "a.nc").read_bytes() == before and len(list(tmp_path.iterdir())) == 1


def test_scores_survive(tmp_path):
    dataset = scored(
        release(), {"nmte_percent": 1.5, "count": 2.0}, {"nmte_percent": "percent", "count": "1"}
    )
    save_dataset(dataset, tmp_path / "a.nc")
    again = open_dataset(tmp_path / "a.nc", "release")
    assert again["score"].values.tolist() == ["nmte_percent", "count"]
    assert again["score_value"].values.tolist() == [1.5, 2.0] and again[
        "score_unit"
    ].values.tolist() == ["percent", "1"]


def test_writers_of_one_file_do_not_meet(tmp_path):
    """Several at once: none fails, a reader sees one content whole, nothing is left behind."""
    path, contents = tmp_path / "a.txt", [str(number) * 100_000 for number in range(8)]
    path.write_text(contents[0])

    def writer(content):
        for _ in range(20):
            write(path, content)
            seen = path.read_text()
            assert seen in contents

    with ThreadPoolExecutor(8) as pool:
        list(pool.map(writer, contents))
    assert [item.name for item in tmp_path.iterdir()] == ["a.txt"]
