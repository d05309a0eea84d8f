"""The outside method's script: a model, or the outcome that stands for it."""

import json
import runpy
import sys
import types

import pytest
from project_copy import ROOT

from vibrom.artefacts.data import open_dataset
from vibrom.models.rom import rom_from_dataset

pytest.importorskip("pysindy")


@pytest.fixture
def fit(beam, tmp_path, monkeypatch):
    """rom.nc of the script with these settings, from `samples` samples."""

    def start(samples=None, **settings):
        monkeypatch.setattr(sys, "stderr", sys.stderr)  # which the script replaces
        train = open_dataset(beam.folder / "train.nc", "trajectory")
        train.isel(time=slice(samples)).to_netcdf(tmp_path / "train.nc")
        files = types.SimpleNamespace
        names = {"scene_name": "beam", "rom_class": "vibrom.latent.polynomial_rom:PolynomialRom"}
        given = {"modes": 1, "degree": 3, "threshold": 1e-4} | settings
        params = types.SimpleNamespace(
            settings=given, provenance={}, **names, items=lambda: {"settings": given}.items()
        )
        job = files(
            input=files(structure=str(beam.folder / "structure.nc"), train=tmp_path / "train.nc"),
            output=files(rom=str(tmp_path / "rom.nc"), losses=str(tmp_path / "losses.nc")),
            params=params,
            log=[str(tmp_path / "log")],
        )
        script = str(ROOT / "workflow/scripts/fit_pysindy_modal.py")
        runpy.run_path(script, init_globals={"snakemake": job}, run_name="__main__")
        return open_dataset(tmp_path / "rom.nc", "rom")

    return start


def test_a_model(fit):
    rom = fit()
    assert rom["outcome"].item() == "ok" and rom.attrs["reason"] == ""
    assert rom_from_dataset(rom).encoder.shape[0] == 1
    assert json.loads(rom.attrs["settings"])["degree"] == 3


def test_a_threshold_that_removes_all_terms_is_an_outcome(fit):
    rom = fit(threshold=1e6)
    assert rom["outcome"].item() == "no_terms" and "encoder" not in rom
    assert rom.attrs["reason"].startswith("threshold = 1e+06 removes every term of the rate")


def test_fewer_samples_than_terms_are_an_outcome(fit):
    rom = fit(samples=5)
    assert rom["outcome"].item() == "underdetermined" and "encoder" not in rom
    assert rom.attrs["reason"].startswith("of 9 coefficients the 5 samples determine 5;")
