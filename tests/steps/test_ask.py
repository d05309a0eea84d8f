"""What becomes of a question: a reference that stopped, a model that was never fitted or lacks what
is needed, a run that blew up, the time that is kept.
"""

import subprocess
import sys
from dataclasses import MISSING, fields, replace

import numpy as np
import pytest
import two_dofs
import xarray as xr

from vibrom.artefacts.data import label, open_dataset, outcome_variables, save_dataset, variable
from vibrom.artefacts.outcome import Outcome
from vibrom.config import plugs
from vibrom.experiments import Experiment, experiment, plug
from vibrom.experiments.frc import ResponseCurve
from vibrom.experiments.run_times import RunTimes
from vibrom.models.training import Unsupported
from vibrom.steps import ask

NAMES = {"scene": "two", "method": "m", "seed": None}
INTEGRATOR = {"rtol": 1e-8, "atol": 1e-10}
SETTINGS = {"forced": {"forcing": 0.05}, "frc": {"forcing": 0.05, "frequencies": 3}}


def settings(name):
    """Those of the scene, and what has no default."""
    needed = [item for item in fields(plug(name)) if item.default is MISSING]
    return {item.name: 0.05 for item in needed} | SETTINGS.get(name, {})


def saved(folder, name, dataset, kind=None):
    """The path of an artefact."""
    if "kind" not in dataset.attrs:
        dataset = label(dataset, kind, scene="two", method="m")
    folder.mkdir(exist_ok=True)
    save_dataset(dataset, folder / f"{name}.nc")
    return str(folder / f"{name}.nc")


@pytest.fixture
def paths(tmp_path):
    """A scene with a fitted model, and what the full order answered."""
    fit = two_dofs.rom().to_dataset().merge(two_dofs.fitted())
    fit = fit.assign_attrs(two_dofs.rom().to_dataset().attrs)
    found = {
        "structure": saved(tmp_path, "structure", two_dofs.structure()),
        "rom": saved(tmp_path, "rom", fit, "rom"),
        "train": saved(tmp_path, "train", two_dofs.record()),
        "test": saved(tmp_path, "test", two_dofs.record()),
    }
    for name in ("forced", "frc"):
        answer = experiment(name, SETTINGS[name]).ask(two_dofs.full_order(), two_dofs.given())
        answer = answer.assign(score_value=variable("score", np.zeros(0), "1", "score"))
        found[name] = saved(tmp_path, name, answer, name)
    return found


def run(folder, paths, *names, **changes):
    """The stored answers of the model at `paths["rom"]`, asked in one job; answers that are read
    and not asked lie below `folder`/model. Of one question, its answer.
    """
    own = {name: str(folder / "model" / f"{name}.nc") for name in plugs.names("experiments")}
    given = {name: own[name] for name in names}
    for name in names:
        for need in plug(name).reads:
            given[need] = own.get(need) or paths["rom" if need == "fit" else need]
        if name != "backbone" and str(plug(name).truth) in paths:
            given[f"truth_{name}"] = paths[str(plug(name).truth)]
    ask.run(
        questions={name: settings(name) for name in names},
        names=NAMES,
        samples=two_dofs.SAMPLES,
        structure=paths["structure"],
        rom=paths["rom"],
        integrator=INTEGRATOR,
        provenance={},
        **(given | changes),
    )
    found = [open_dataset(own[name], name) for name in names]
    return found[0] if len(found) == 1 else found


def score(answer, name):
    """One score."""
    return float(answer["score_value"].sel(score=name))


def test_a_stored_answer_has_scores_settings_and_no_bulk(tmp_path, paths):
    answer = run(tmp_path, paths, "decay")
    assert answer["outcome"].item() == "ok" and score(answer, "nmte_percent") < 0.01
    assert "displacement" not in answer and answer["error"].max() < 1e-4
    assert '"rtol": 1e-08' in answer.attrs["settings"]


def test_questions_in_one_job_are_answered_as_one_by_one(tmp_path, paths):
    """An answer that the next question reads is the one that was just given."""
    names = ("decay", "backbone", "eigenvalues", "forced", "frc", "run_times")
    for name in names:
        run(tmp_path / "alone", paths, name)
    together = run(tmp_path / "together", paths, *names)
    for name, answer in zip(names, together):
        alone = open_dataset(tmp_path / f"alone/model/{name}.nc", name)
        times = ["seconds", *(key for key in answer if key.endswith("_s"))]
        times += ["score_value"] if name == "run_times" else []
        xr.testing.assert_identical(
            answer.drop_vars(times, errors="ignore").drop_attrs(deep=False),
            alone.drop_vars(times, errors="ignore").drop_attrs(deep=False),
        )
        assert answer.attrs["settings"] == alone.attrs["settings"]
    assert score(together[-1], "decay_s") == float(together[0]["seconds"])
    assert score(together[-1], "frc_s") == float(together[4]["seconds"])


def test_a_short_job_imports_no_package_that_takes_longer_than_it():
    """A hundred jobs ask a fitted model; each of these takes 0.2 to 1.5 s to import."""
    asked = [name for name in plugs.names("experiments") if plug(name).job == "answers"]
    used = ["steps.ask", "models.reduced", "solvers.reduced.steppers.dop853"]
    code = f"""
import importlib, sys
for name in {[*used, *(f"experiments.{name}" for name in asked)]}:
    importlib.import_module(f"vibrom.{{name}}")
scipy = ("stats", "optimize", "integrate", "interpolate", "signal")
print({{"torch", "skfem", *(f"scipy.{{name}}" for name in scipy)}} & set(sys.modules))
"""
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert len(asked) > 5 and found.stdout == "set()\n"


def test_a_reference_that_stopped_is_no_verdict_on_the_model(tmp_path, paths):
    stopped = two_dofs.record().assign(outcome_variables("no_convergence", 0.05))
    answer = run(tmp_path, paths | {"test": saved(tmp_path, "stopped", stopped)}, "decay")
    assert answer["outcome"].item() == "reference_failed" and np.isnan(answer["score_value"]).all()


def test_a_model_that_could_not_be_fitted_is_evaluated_by_no_experiment(tmp_path, paths):
    """Every experiment says why there is no answer, also those that only read other answers, and
    has no value in any of its scores.
    """
    unfit = xr.Dataset({"outcome": variable((), "training_diverged", "1", "fit")})
    unfit = unfit.assign_attrs(reason="loss is NaN in epoch 3")
    paths = paths | {"rom": saved(tmp_path, "unfit", unfit, "rom")}
    for name in sorted(
        plugs.names("experiments"),
        key=lambda name: len({*plug(name).reads} - {"train", "test", "fit"}),
    ):
        answer = run(tmp_path, paths, name)
        assert answer["outcome"].item() == "training_diverged", name
        assert answer.attrs["reason"] == "loss is NaN in epoch 3" and not answer.attrs["answered"]
        units = dict(zip(answer["score"].values, answer["score_unit"].values))
        assert units == dict(plug(name).scores) and np.isnan(answer["score_value"]).all(), name


def test_a_model_without_a_force_map_is_skipped_with_the_reason(tmp_path, paths, monkeypatch):
    def motion(self, *given):
        raise Unsupported("PolynomialRom has no force map")

    monkeypatch.setattr("vibrom.models.reduced.Reduced.motion", motion)
    answer = run(tmp_path, paths, "frc")
    assert answer["outcome"].item() == "skipped" and "no force map" in answer.attrs["reason"]


@pytest.mark.parametrize("missing", [None, 1])
def test_points_without_a_reference_are_left_out(missing):
    asked = ResponseCurve(forcing=0.05, frequencies=3)
    answer = asked.ask(two_dofs.reduced(), two_dofs.given())
    reference = answer["amplitude"].values * 1.02
    if missing is not None:
        reference[:, missing] = np.nan
    scores = asked.score(answer, answer.assign(amplitude=answer["amplitude"].copy(data=reference)))
    assert scores["amplitude_error_median_percent"] == pytest.approx(100 * (1 - 1 / 1.02))
    assert np.isnan(scores["peak_error_percent"]) == (missing is not None)


def test_a_point_that_failed_is_infinitely_wrong_and_a_curve_with_gaps_has_no_peak():
    """Ten times the reach ends a run: here at resonance alone."""
    asked, exact = ResponseCurve(forcing=0.05, frequencies=3), two_dofs.reduced()
    truth = asked.ask(exact, two_dofs.given())
    largest = truth["half_range"].values[1].max()  # of the second mass: 1 in the first mode
    reach = 0.08 * largest * np.concatenate([np.ones(2), two_dofs.FREQUENCIES])
    answer = asked.ask(
        replace(exact, rom=replace(exact.rom, reach=reach)),
        two_dofs.given(),
    )
    scores = asked.score(answer, truth)
    assert answer["outcome"].values.tolist().count("diverged") == 1 and scores["completed"] == 2
    # Two of three points are right, to the integrator's tolerance of 1e-8: the median is.
    assert scores["amplitude_error_median_percent"] < 1e-4
    assert np.isnan(scores["peak_error_percent"])


def test_times_are_the_least_of_a_few_calls():
    class Question(Experiment):
        times = iter([9.0, 0.12, 0.05, 0.09])

        def ask(self, model, given):
            return xr.Dataset(outcome_variables("ok", seconds=next(self.times)))

    answer = ask.evaluated(Question(), None, two_dofs.given(), None, warm=True)
    assert float(answer["seconds"]) == 0.05


def test_a_run_that_blew_up_has_no_time():
    ended = {
        name: xr.Dataset(outcome_variables(outcome, seconds=0.5))
        for name, outcome in (("train", "ok"), ("decay", "left_range"), ("forced", "diverged"))
    }
    words = np.array(["ok", "step_underflow"], dtype=object)
    curve = xr.Dataset(outcome_variables("ok", seconds=2.0)).assign(
        outcome=variable("angular_frequency", words, "1", "outcome")
    )
    answer = RunTimes().ask(None, two_dofs.given(**ended, frc=curve))
    times = RunTimes().score(answer, None)
    assert (times["generate_training_data_s"], times["obtain_mapping_s"]) == (0.5, 3.0)
    assert times["decay_s"] == 0.5 and np.isnan([times["forced_s"], times["frc_s"]]).all()
    assert answer["outcome"].item() == Outcome.DIVERGED
