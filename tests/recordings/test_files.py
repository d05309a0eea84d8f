"""Recordings come back as they were written, in whatever kind of file; what cannot be used is
refused in one line that names the file.
"""

from pathlib import Path

import netCDF4
import numpy as np
import pytest
import scipy.io.matlab
import xarray as xr
from oscillator import Oscillator
from scipy.io import savemat
from scipy.sparse import csc_matrix

from vibrom.artefacts.files import DataError
from vibrom.config.recorded import RecordedScene, Recording
from vibrom.recordings import files, samples

TIME = np.arange(0.0, 4.0, 1 / 200)
X = np.stack([Oscillator().motion(TIME, 1.0), 0.5 * Oscillator().motion(TIME, 1.0)], axis=1)
PERIOD = 0.2


def cell(*items):
    made = np.empty((1, len(items)), object)
    for place, item in enumerate(items):
        made[0, place] = item
    return made


def csv(path, text="time [ms],a [mm],b [mm]\n", delimiter=",", decimal="."):
    rows = np.column_stack([1e3 * TIME, 1e3 * X])
    lines = [delimiter.join(f"{value:.12g}".replace(".", decimal) for value in row) for row in rows]
    path.write_text(text + "\n".join(lines) + "\n")


MAKE = {
    "comma.csv": csv,
    "semicolon.csv": lambda path: csv(path, "", ";", ","),
    "blanks.txt": lambda path: csv(path, "# a comment\n", "  "),
    "columns.npy": lambda path: np.save(path, np.column_stack([1e3 * TIME, 1e3 * X])),
    "rows.npy": lambda path: np.save(path, np.vstack([1e3 * TIME, 1e3 * X.T])),
    "named.npz": lambda path: np.savez(path, time=1e3 * TIME, a=1e3 * X[:, 0], b=1e3 * X[:, 1]),
    "transposed.npz": lambda path: np.savez(path, t=1e3 * TIME, x=1e3 * X.T),
    "plain.mat": lambda path: savemat(path, {"t": 1e3 * TIME, "x": 1e3 * X}),
    "netcdf.nc": lambda path: xr.Dataset(
        {"x": (("time", "channel"), 1e3 * X)}, coords={"time": 1e3 * TIME}
    ).to_netcdf(path),
}


def scene(*recordings, **changes):
    given = {"time_unit": "ms", "length_unit": "mm"} | changes
    return RecordedScene(
        kind="recorded", name="it", description="", recordings=tuple(recordings), **given
    )


def loaded(path, **entry):
    item = Recording(file=str(path), role="train", **entry)
    return samples.loaded(item, scene(item, item))


@pytest.mark.parametrize("name", MAKE)
def test_every_kind_of_file_holds_the_same_motion_in_si_units(tmp_path, name):
    MAKE[name](tmp_path / name)
    found = loaded(tmp_path / name)
    np.testing.assert_allclose(found.time, TIME, atol=1e-12)
    np.testing.assert_allclose(found.values, X, atol=1e-11)  # twelve digits are written
    assert not found.notes


def test_entries_of_cells_and_fields_have_names_as_matlab_writes_them(tmp_path):
    path = tmp_path / "cells.mat"
    savemat(path, {"xData": cell(TIME, X.T), "sweep": {"omega": np.arange(3.0)}})
    assert set(files.read(path)) == {"xData{1,1}", "xData{1,2}", "sweep.omega"}
    found = loaded(path, time="xData{1,1}", channels=("xData{1,2}",))
    np.testing.assert_array_equal(found.values, 1e-3 * X)


def matlab_73(path, fill):
    """HDF5 behind a header of 512 bytes, arrays transposed, as MATLAB writes it."""
    with netCDF4.Dataset(path.with_suffix(".hdf5"), "w") as data:
        fill(data)
    head = b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM"
    path.write_bytes(head.ljust(512, b"\x00") + path.with_suffix(".hdf5").read_bytes())


def put(group, name, values, kind="double"):
    dims = [f"{name}_{axis}" for axis in range(np.ndim(values))]
    for dim, size in zip(dims, np.shape(values)[::-1]):
        group.createDimension(dim, size)
    made = group.createVariable(name, np.asarray(values).dtype, dims)
    made[...] = np.transpose(values)
    made.MATLAB_class = kind


def test_matlab_73_holds_arrays_fields_and_sparse_matrices(tmp_path):
    matrix = csc_matrix(np.array([[2.0, -1.0, 0.0], [0.0, 3.0, 0.5]]))

    def fill(data):
        put(data, "t", 1e3 * TIME[None])
        put(data, "x", 1e3 * X)
        put(data, "note", np.array([[72, 105]], np.uint16), "char")
        put(data.createGroup("sweep"), "omega", np.arange(3.0)[None])
        sparse = data.createGroup("K")
        sparse.MATLAB_sparse = np.uint64(2)
        for name, values in zip(("data", "ir", "jc"), (matrix.data, matrix.indices, matrix.indptr)):
            put(sparse, name, values)

    path = tmp_path / "new.mat"
    matlab_73(path, fill)
    arrays = files.read(path)
    assert set(arrays) == {"t", "x", "sweep.omega", "K"}
    np.testing.assert_array_equal(arrays["K"], matrix.toarray())
    found = loaded(path, time="t", channels=("x",))
    np.testing.assert_allclose(found.values, X, rtol=1e-15)


def test_cells_of_matlab_73_are_refused(tmp_path, monkeypatch):
    """MATLAB keeps them in a group whose name netCDF reads, but does not write."""
    monkeypatch.setattr(files, "CELLS", "refs")
    matlab_73(tmp_path / "new.mat", lambda data: put(data.createGroup("refs"), "a", X))
    with pytest.raises(DataError, match="holds cells, which are not read from MATLAB 7.3"):
        files.read(tmp_path / "new.mat")


def test_a_file_that_matlab_itself_wrote():
    """Of SciPy's own tests: 0 to 2 pi in steps of pi/4."""
    folder = Path(scipy.io.matlab.__file__).parent / "tests/data"
    path = folder / "testhdf5_7.4_GLNX86.mat"
    if not path.is_file():
        pytest.skip("SciPy is installed without its tests")
    found = files.read(path)
    np.testing.assert_allclose(found["testdouble"], [np.arange(9) * np.pi / 4], rtol=1e-14)


def test_samples_without_instants_have_a_step(tmp_path):
    np.save(tmp_path / "x.npy", X[:, :1])
    np.testing.assert_allclose(loaded(tmp_path / "x.npy", step=5.0).time, TIME, atol=1e-12)


@pytest.mark.parametrize(
    ("name", "content", "entry", "says"),
    [
        ("it.xlsx", b"", {}, "files of this kind are not read"),
        ("it.mat", b"MATLAB 5.0 MAT-file, torn", {}, "cannot be read"),
        ("it.npy", b"\x93NUMPY torn", {}, "cannot be read"),
        ("it.nc", b"no netCDF", {}, "cannot be read"),
        ("it.csv", b"", {}, "holds no numbers"),
        ("it.csv", b"a,b\nx,y\n", {}, "holds no numbers"),
        ("it.csv", b"t,x\n0,1\n1,2\n", {"channels": ("y",)}, "holds no 'y'; choose from t, x"),
        ("it.csv", b"t,x\n0,1\n1,2\n", {"begin": 5.0}, "its time is 0 to 1"),
        ("it.csv", b"t,x\n0,1\n0,2\n0,3\n", {}, "2 of 3 instants are repeated"),
        ("it.npy", None, {}, "no such file"),
    ],
)
def test_what_cannot_be_used_is_one_line(tmp_path, name, content, entry, says):
    path = tmp_path / name
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(DataError) as caught:
        loaded(path, **entry)
    line = str(caught.value)
    assert says in line and str(path) in line and "\n" not in line


def test_a_shape_that_fits_no_time_is_refused(tmp_path):
    np.savez(tmp_path / "x.npz", t=TIME[:-1], x=X)
    with pytest.raises(DataError, match="x is 800 x 2, but there are 799 instants"):
        loaded(tmp_path / "x.npz")


def test_recordings_with_different_channels_are_refused(tmp_path):
    for name, values in (("one", X[:, :1]), ("two", X)):
        np.savez(tmp_path / f"{name}.npz", t=TIME, x=values)
    both = [Recording(file=str(tmp_path / f"{n}.npz"), role="train") for n in ("one", "two")]
    with pytest.raises(DataError, match=r"two.npz \(train\): 2 channels, but .*one.npz"):
        samples.load(scene(*both))


def test_channels_are_told_by_their_names_whatever_their_order(tmp_path):
    np.savez(tmp_path / "one.npz", t=TIME, a=X[:, 0], b=X[:, 1])
    np.savez(tmp_path / "two.npz", t=TIME, b=X[:, 1], a=X[:, 0])
    both = [Recording(file=str(tmp_path / f"{n}.npz"), role="train") for n in ("one", "two")]
    first, second = samples.load(scene(*both))
    np.testing.assert_array_equal(first.values, second.values)
    assert second.notes == ("channels in the order of the first recording",)


def test_infinite_samples_are_missing(tmp_path):
    values = X.copy()
    values[100, 0] = np.inf
    np.savez(tmp_path / "x.npz", t=TIME, x=values)
    assert np.isnan(loaded(tmp_path / "x.npz").values[100, 0])


def sampled(time, values=None):
    values = Oscillator().motion(time, 1.0)[:, None] if values is None else values
    return samples.Samples("it", "train", time, values, ("x",))


def test_irregular_instants_and_missing_samples_are_filled_in():
    """By the spline of degree five: (omega h)^6/720 = 2e-8 of steps 0.02 of a period, longer ones
    where samples are missing.
    """
    random = np.random.default_rng(1)
    time = np.arange(0.0, 4.0, 0.02 * PERIOD)
    time[1:-1] += 0.2 * 0.02 * PERIOD * random.uniform(-1, 1, len(time) - 2)
    made = sampled(time)
    made.values[random.integers(2, len(time) - 2, 60)] = np.nan
    found = samples.equidistant(made, PERIOD, 0.1, made.step)
    np.testing.assert_allclose(np.diff(found.time), found.step, rtol=1e-9)
    np.testing.assert_allclose(
        found.values[:, 0], Oscillator().motion(found.time, 1.0), atol=2e-5, rtol=0.0
    )
    assert "missing samples filled in, resampled at" in found.notes[0]


def test_instants_out_of_order_are_put_in_order():
    order = np.random.default_rng(0).permutation(len(TIME))
    made = samples.in_order(sampled(TIME[order]), 1.0)
    np.testing.assert_array_equal(made.values[:, 0], X[:, 0])
    assert made.notes == ("instants put in order",)


def test_samples_without_an_instant_are_left_out_and_noted(tmp_path):
    time = 1e3 * TIME
    time[5] = np.nan
    np.savez(tmp_path / "x.npz", t=time, x=1e3 * X)
    for entry in ({}, {"end": 3000.0}):
        found = loaded(tmp_path / "x.npz", **entry)
        assert found.notes == ("1 samples without an instant left out",)
        np.testing.assert_allclose(found.time[4:6], TIME[[4, 6]], atol=1e-12)


@pytest.mark.parametrize(
    ("time", "says"),
    [
        (np.r_[0:1:0.005, 1.1:4:0.005], "no sample for 0.105 s after 0.995 s, more than"),
        (np.r_[0:4:0.05], "4.0 samples of a period"),
        (np.r_[0:1:0.005], "5.0 periods of 0.2 s; record at least 10, or correct time_unit"),
    ],
)
def test_what_samples_do_not_show_is_refused(time, says):
    with pytest.raises(DataError) as caught:
        samples.equidistant(sampled(time), PERIOD, 0.1, sampled(time).step)
    assert says in str(caught.value) and "\n" not in str(caught.value)


def test_a_wrong_unit_of_time_is_told_by_the_other_recordings():
    wrong = samples.Samples("wrong.csv", "test", 1e3 * TIME, X, ("a", "b"))
    right = samples.Samples("right.csv", "train", TIME, X, ("a", "b"))
    with pytest.raises(DataError, match="its first frequency is .* correct time_unit"):
        samples.common_frequency([right, right, wrong], None)
    assert samples.common_frequency([right, right], None) == pytest.approx(5.15, abs=0.1)
