"""`vibrom record` writes the file of a scene that the configuration takes as it is."""

import shutil
import sys
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from oscillator import Oscillator
from scipy.io import savemat

from vibrom.__main__ import main
from vibrom.config import settings
from vibrom.recordings import samples

CONFIG = Path(__file__).parents[2] / "config"
TIME = np.arange(0.0, 6.0, 1 / 200)


@pytest.fixture
def here(tmp_path, monkeypatch):
    shutil.copytree(CONFIG, tmp_path / "config")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def record(monkeypatch, *arguments):
    monkeypatch.setattr(sys, "argv", ["vibrom", "record", *arguments])
    main()


def csv(path, start, began=0.0):
    x = 1e3 * Oscillator().motion(TIME, start)
    rows = np.column_stack([began + 1e3 * TIME, x])
    np.savetxt(path, rows, delimiter=",", header="time [ms],tip [mm]", comments="")


def scene(here):
    found = settings.load(here / "config", [], {"scenes": ["mine"]})
    return found.scenes["mine"]


def test_files_of_one_decay_each(here, monkeypatch, capsys):
    for name, start in (("a.csv", 1.0), ("b.csv", 0.7), ("c.csv", 0.8)):
        csv(here / name, start)
    record(monkeypatch, "a.csv", "b.csv", "c.csv", "--out", "config/scenes/mine.yaml")
    made, said = scene(here), capsys.readouterr().out
    assert [item.role for item in made.recordings] == ["train", "train", "test"]
    assert (made.time_unit, made.length_unit) == ("ms", "mm")
    assert "3 recordings, first frequency 5.0" in said and "30 periods of" in said


def test_the_recording_that_swings_farthest_is_learnt_from(here, monkeypatch):
    for name, start in (("a.csv", 0.5), ("b.csv", 0.8), ("c.csv", 1.0)):
        csv(here / name, start)
    record(monkeypatch, "a.csv", "b.csv", "c.csv", "--out", "config/scenes/mine.yaml")
    assert [item.role for item in scene(here).recordings] == ["train", "test", "train"]


@pytest.mark.parametrize("began", [0.0, 1.7e12])  # ms: also of a clock that counts from 1970
def test_one_decay_is_cut_in_the_middle(here, monkeypatch, began):
    csv(here / "a.csv", 1.0, began)
    record(monkeypatch, "a.csv", "--out", "config/scenes/mine.yaml")
    first, second = scene(here).recordings
    assert first.role == "train" and second.role == "test"
    assert first.end == second.begin == pytest.approx(began + 3000.0, rel=0.0, abs=10.0)


def test_a_cell_of_instants_and_channels_holds_several(here, monkeypatch):
    made = np.empty((2, 2), object)
    for row, start in enumerate((1.0, 0.8)):
        made[row] = [TIME, None]
        made[row, 1] = Oscillator().motion(TIME, start)[None]
    savemat(here / "a.mat", {"xData": made, "dt": 0.005})
    record(monkeypatch, "a.mat", "--out", "config/scenes/mine.yaml")
    found = scene(here).recordings
    assert [item.time for item in found] == ["xData{1,1}", "xData{2,1}"]


def test_a_counter_is_no_channel_and_instants_are_known_by_their_name(here, monkeypatch):
    for name, start in (("a.csv", 1.0), ("b.csv", 0.8)):
        rows = [np.arange(len(TIME)), 1e3 * TIME, Oscillator().motion(TIME, start)]
        header = "index,Time (ms),x (m)"
        np.savetxt(here / name, np.transpose(rows), delimiter=",", header=header, comments="")
    record(monkeypatch, "a.csv", "b.csv", "--out", "config/scenes/mine.yaml")
    made = scene(here)
    assert made.recordings[0].time == "Time (ms)" and made.recordings[0].channels == ("x (m)",)
    assert made.time_unit == "ms"


def test_samples_without_instants_have_the_step_that_is_said(here, monkeypatch, capsys):
    for name, start in (("a", 1.0), ("b", 0.8)):
        np.savez(here / f"{name}.npz", x=Oscillator().motion(TIME, start), rate=200.0)
    arguments = "a.npz", "b.npz", "--step", "0.005", "--out", "config/scenes/mine.yaml"
    record(monkeypatch, *arguments)
    assert [(item.step, item.channels) for item in scene(here).recordings] == [(0.005, ("x",))] * 2
    assert "first frequency 5.0" in capsys.readouterr().out


def test_a_motion_under_a_signal_is_predicted(here, monkeypatch):
    for name, start in (("a.csv", 1.0), ("b.csv", 0.8)):
        csv(here / name, start)
    shaken = 1e3 * TIME, 1e3 * Oscillator().motion(TIME, 0.1), np.sin(20.0 * TIME)
    header = "time [ms],tip [mm],base [m/s2]"
    np.savetxt("c.csv", np.transpose(shaken), delimiter=",", header=header, comments="")
    arguments = "a.csv", "b.csv", "--forced", "c.csv", "--out", "config/scenes/mine.yaml"
    with pytest.raises(SystemExit, match="give --forced FILE and --signal NAME together"):
        record(monkeypatch, *arguments)
    record(monkeypatch, *arguments, "--signal", "base [m/s2]")
    made = scene(here)
    assert [item.role for item in made.recordings] == ["train", "test", "forced"]
    assert made.recordings[2].signal == "base [m/s2]"
    assert made.recordings[2].channels == ("tip [mm]",)
    assert "measured_forcing" in made.experiments


def test_units_and_dates_of_netcdf_are_taken_from_its_attributes(here, monkeypatch):
    for name, start in (("a.nc", 1.0), ("b.nc", 0.8)):
        x = "time", 1e3 * Oscillator().motion(TIME, start), {"units": "mm"}
        instants = np.datetime64("2024-01-01", "ns") + (1e9 * TIME).astype("timedelta64[ns]")
        xr.Dataset({"x": x}, {"time": instants}).to_netcdf(here / name)
    record(monkeypatch, "a.nc", "b.nc", "--out", "config/scenes/mine.yaml")
    made = scene(here)
    assert (made.time_unit, made.length_unit) == ("s", "mm")
    first = samples.load(made)[0]
    np.testing.assert_allclose(first.time - first.time[0], TIME, atol=1e-6)


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["none.csv", "--out", "config/scenes/mine.yaml"], "none.csv: no such file"),
        (["a.csv", "--out", "config/scenes/small.yaml"], "is there already"),
        (["a.csv", "--out", "config/scenes/my scene.yaml"], "the name of a scene has letters"),
        (["a.csv", "a.csv", "--out", "config/scenes/mine.yaml"], "a.csv: is given twice"),
        (["b.npz", "--out", "config/scenes/mine.yaml"], "no instants among x, y"),
        (["b.npz", "--step", "-1", "--out", "config/scenes/mine.yaml"], "step = -1: give the time"),
        (["b.npz", "--step", "nan", "--out", "config/scenes/mine.yaml"], "step = nan: give"),
    ],
)
def test_what_cannot_be_a_scene_is_one_line(here, monkeypatch, arguments, says):
    csv(here / "a.csv", 1.0)
    np.savez(here / "b.npz", x=np.cos(TIME), y=np.sin(TIME))
    with pytest.raises(SystemExit) as caught:
        record(monkeypatch, *arguments)
    line = str(caught.value)
    assert line.startswith("vibrom: ") and says in line and "\n" not in line
    assert not (here / "config/scenes/mine.yaml").exists()
