"""What cannot be compared says so: a full-order run that stopped, a model that was never fitted, a
curve with gaps.
"""

import numpy as np
import pytest
import xarray as xr
from oscillators import OMEGA, linear_rom

from vibrom import experiments
from vibrom.artefacts.data import label, open_dataset, outcome_variables, save_dataset, variable
from vibrom.experiments import frc, run_times
from vibrom.models.rollout import Integrator
from vibrom.steps import experiment, fit

SETTINGS = {"rtol": 1e-8, "atol": 1e-10}


def structure():
    known = xr.Dataset(
        {
            "node": variable(("vertex", "axis"), np.zeros((1, 2)), "m", "vertices"),
            "element_node": variable(("element", "corner"), np.zeros((1, 4)), "1", "corners"),
            "dof_node": variable("dof", [0], "1", "vertex"),
            "dof_axis": variable("dof", [1], "1", "direction"),
            "mode_shape": variable(("mode", "dof"), np.ones((1, 1)), "kg-0.5", "modes"),
            "frequency": variable("mode", [OMEGA], "rad s-1", "frequencies"),
            "load": variable("dof", [1.0], "N", "load"),
            "probe_dof": variable("probe", [0], "1", "probe"),
        },
        coords={"probe": variable("probe", np.array(["probe"], dtype=object), "1", "name")},
    )
    return label(known, "structure", scene="s", method="full_order", body={}, effects={})


def motion(outcome, failed_at=np.nan):
    time = np.linspace(0, 0.1, 60)
    q = 0.1 * np.cos(OMEGA * time)[:, None]
    fields = {
        name: variable(("time", "dof"), q, units, name)
        for name, units in (("displacement", "m"), ("velocity", "m s-1"), ("acceleration", "m s-2"))
    }
    dataset = xr.Dataset(
        {
            **fields,
            "probe_displacement": variable(("probe", "time"), q.T, "m", "probe"),
            **outcome_variables(outcome, failed_at),
        },
        coords={
            "time": variable("time", time, "s", "time"),
            "probe": variable("probe", np.array(["probe"], dtype=object), "1", "name"),
        },
    )
    return label(dataset, "trajectory", scene="s", method="full_order")


def curve(reference):
    dataset = xr.Dataset(
        {
            "amplitude": variable(
                ("probe", "angular_frequency"), reference[None], "m", "amplitude"
            ),
            "phase": variable(("probe", "angular_frequency"), reference[None], "rad", "phase"),
            "forcing": variable((), 1.0, "1", "forcing"),
            **outcome_variables("ok"),
        },
        coords={
            "angular_frequency": variable(
                "angular_frequency", OMEGA * np.array([0.9, 1.0, 1.1]), "rad s-1", "frequency"
            )
        },
    )
    return label(dataset, "frc", scene="s", method="full_order", periods=5)


def saved(dataset, path):
    save_dataset(dataset, path)
    return str(path)


def test_a_reference_that_stopped_is_no_verdict_on_the_model(tmp_path):
    fitted = label(
        linear_rom().to_dataset().assign(outcome=variable((), "ok", "1", "fit")),
        "rom",
        scene="s",
        method="m",
    )
    paths = {
        "structure": saved(structure(), tmp_path / "structure.nc"),
        "rom": saved(fitted, tmp_path / "rom.nc"),
        "test": saved(motion("no_convergence", 0.05), tmp_path / "test.nc"),
    }
    experiment.run(
        output=str(tmp_path / "decay.nc"),
        experiment="decay",
        scene_name="s",
        method="m",
        seed=None,
        integrator=SETTINGS,
        provenance={},
        **paths,
    )
    answer = open_dataset(tmp_path / "decay.nc", "decay")
    assert answer["outcome"].item() == "reference_failed" and np.isnan(answer["score_value"]).all()


def test_a_model_is_not_fitted_to_a_motion_that_stopped(tmp_path):
    paths = {
        "structure": saved(structure(), tmp_path / "structure.nc"),
        "train": saved(motion("no_convergence", 0.05), tmp_path / "train.nc"),
        "test": saved(motion("ok"), tmp_path / "test.nc"),
    }
    fit.run(
        rom=str(tmp_path / "rom.nc"),
        losses=str(tmp_path / "losses.nc"),
        scene_name="s",
        method="ssmlearn",
        settings={},
        seed=None,
        device="cpu",
        provenance={},
        **paths,
    )
    rom = open_dataset(tmp_path / "rom.nc", "rom")
    assert (
        rom["outcome"].item() == "reference_failed" and "stopped at 0.05 s" in rom.attrs["reason"]
    )


@pytest.mark.parametrize("missing", [None, 1])
def test_points_without_a_reference_are_left_out(missing):
    whole = frc.predict(
        {"rom": linear_rom(), "structure": structure(), "frc": curve(np.ones(3))}, Integrator()
    )
    reference = whole["amplitude"].values[0] * 1.02
    if missing is not None:
        reference[missing] = np.nan
    score = frc.predict(
        {"rom": linear_rom(), "structure": structure(), "frc": curve(reference)}, Integrator()
    )["score_value"]
    assert float(score.sel(score="amplitude_error_median_percent")) == pytest.approx(
        100 * (1 - 1 / 1.02), rel=1e-6
    )
    assert np.isnan(score.sel(score="peak_error_percent")) == (missing is not None)


def test_a_curve_that_lost_its_peak_has_no_error_to_tell():
    """Ten times the reach ends a run: here at resonance alone."""
    whole = frc.predict(
        {"rom": linear_rom(), "structure": structure(), "frc": curve(np.ones(3))}, Integrator()
    )["amplitude"].values[0]
    # After five periods from rest the beats beside resonance reach two thirds of the resonance.
    reach = 0.085 * whole[1] * np.array([1.0, OMEGA])
    answer = frc.predict(
        {"rom": linear_rom(reach=reach), "structure": structure(), "frc": curve(whole)},
        Integrator(),
    )
    assert (
        answer["outcome"].values.tolist()[1] == "diverged"
        and float(answer["score_value"].sel(score="completed")) == 2
    )
    assert np.isnan(
        answer["score_value"].sel(score=["amplitude_error_median_percent", "peak_error_percent"])
    ).all()


def test_times_are_the_least_of_a_few_calls():
    class Module:
        times = iter([0.3, 0.1, 0.2])

        @staticmethod
        def predict(artefacts, settings):
            return xr.Dataset(outcome_variables("ok", seconds=next(Module.times)))

    assert float(experiment.quickest(Module, {}, None)["seconds"]) == 0.1


def test_a_model_that_could_not_be_fitted_is_asked_everything(tmp_path):
    """Every experiment says why there is no answer, also those that only read other answers, and
    has no value in any of its scores.
    """
    unfit = label(
        xr.Dataset({"outcome": variable((), "training_diverged", "1", "fit")}),
        "rom",
        scene="s",
        method="m",
    )
    paths = {
        "structure": structure(),
        "rom": unfit,
        "train": motion("ok"),
        "test": motion("ok"),
        "forced": label(motion("ok"), "forced", scene="s", method="full_order"),
        "frc": curve(np.ones(3)),
    }
    paths = {name: saved(dataset, tmp_path / f"{name}.nc") for name, dataset in paths.items()}
    for name in (
        "reconstruction",
        "decay",
        "backbone",
        "forced",
        "frc",
        "eigenvalues",
        "run_times",
    ):
        needs, units = experiments.load(name).needs, experiments.load(name).scores
        answers = {
            need: str(tmp_path / "model" / f"{need}.nc")
            if need in ("decay", "forced", "frc") and name == "run_times" or need == "decay"
            else paths[need]
            for need in needs
        }
        output = tmp_path / "model" / f"{name}.nc"
        experiment.run(
            output=str(output),
            experiment=name,
            scene_name="s",
            method="m",
            seed=None,
            integrator=SETTINGS,
            provenance={},
            **answers,
        )
        answer = open_dataset(output, name)
        assert answer["outcome"].item() == "training_diverged", name
        assert (
            dict(zip(answer["score"].values, answer["score_unit"].values)) == units
            and np.isnan(answer["score_value"]).all()
        ), name


def test_a_run_that_blew_up_has_no_time():
    ended = {
        name: xr.Dataset(outcome_variables(outcome, seconds=0.5))
        for name, outcome in (("train", "ok"), ("decay", "left_range"), ("forced", "diverged"))
    }
    curve = xr.Dataset(outcome_variables("ok", seconds=2.0)).assign(
        outcome=variable(
            "angular_frequency", np.array(["ok", "step_underflow"], dtype=object), "1", "outcome"
        )
    )
    fitted = xr.Dataset(
        {
            "outcome": variable((), "ok", "1", "fit"),
            "mapping_seconds": variable((), 3.0, "s", "fit"),
            "dynamics_seconds": variable((), 0.1, "s", "fit"),
        }
    )
    answer = run_times.predict({**ended, "frc": curve, "rom": fitted}, Integrator())
    times = dict(zip(answer["score"].values, answer["score_value"].values))
    assert (times["generate_training_data_s"], times["obtain_mapping_s"], times["decay_s"]) == (
        0.5,
        3.0,
        0.5,
    )
    assert (
        np.isnan([times["forced_s"], times["frc_s"]]).all()
        and answer["outcome"].item() == "diverged"
    )
