"""The whole workflow in miniature: all is made, nothing is made twice, and an edit makes its own
jobs run again.
"""

import json
import re
import shutil

import numpy as np
import pytest
import xarray as xr
from miniature import Run
from project_copy import RUNS, plan, warm
from rocrate.rocrate import ROCrate
from warm_jobs import PEAKS

from vibrom.artefacts.data import KINDS, open_dataset
from vibrom.config import plugs
from vibrom.config.memory import HELD
from vibrom.report import outputs

SEEDED = ("split", "split_plus")
FITTED_ONCE = ("ssmlearn", "ssmlearn_11", "pysindy_modal", "equations")
EXPERIMENTS = ("reconstruction", "decay", "backbone", "forced", "frc", "eigenvalues", "run_times")
EXPERIMENTS += ("branches", "s_curve", "resonance", "sweeps", "response")
ASKED = {"answers", "curves"}  # the jobs in which those are asked of a model
ROBUSTNESS = {"robustness_model", "robustness_tables", "robustness_figures_of_scene"}
COST = {"cost_models", "cost_tables", "cost_figures"}
TRUST = {"trust_models", "trust_tables", "trust_figures"}
SINKS = {"scores", "models_tables", "models_figures", "models_figures_of_scene"}
SINKS |= {"report", "tracking", "crate", "headline", "all"}


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """All that is shown is made in forks of a warm process, and the rest by the plain command."""
    made = Run(tmp_path_factory.mktemp("small"))
    with warm(made.folder) as start:
        answer = made.snakemake(
            "--cores", "2", "report", "scores", "tables", "figures", start=start
        )
    assert answer.returncode == 0, (answer.stdout + answer.stderr)[-6000:]
    answer = made.snakemake("--cores", "2")
    assert answer.returncode == 0, (answer.stdout + answer.stderr)[-6000:]
    made.answer = answer
    return made


def test_the_run_says_what_was_made_from_what(run):
    described = ROCrate(str(run.results))
    action = described.get("#made/folding/split/seed_0/decay.nc")
    files = {one.id for one in action["object"] if one.type == "File"}
    own = {"folding/split/seed_0/rom.nc", "folding/full_order/structure.nc"}
    assert own | {"folding/full_order/test.nc"} <= files
    (settings,) = (one for one in action["object"] if one.type == "PropertyValue")
    assert json.loads(settings["value"])["integrator"]["rtol"] == 1e-4
    every = {str(path.relative_to(run.results)) for path in run.contents()}
    kept = {name for name in every if not name.startswith("mlflow_artifacts")}
    assert kept <= {entity.id for entity in described.data_entities}


def test_every_artefact_is_there_and_says_what_made_it(run):
    folders = [f"{method}/seed_0" for method in SEEDED] + [
        f"{method}/unseeded" for method in FITTED_ONCE
    ]
    for folder in folders:
        for name in ("rom", "losses", *EXPERIMENTS, "robustness"):
            data = open_dataset(run.results / "folding" / folder / f"{name}.nc", name)
            assert data.attrs["scene"] == "folding" and data.attrs["method"] == folder.split("/")[0]
            assert len(data.attrs["source_digest"]) == 16 and "python" in json.loads(
                data.attrs["versions"]
            )
    for path in (run.results / "folding/full_order").glob("*.nc"):
        kind = {"train": "trajectory", "test": "trajectory"}.get(path.stem, path.stem)
        assert kind in {*KINDS, *EXPERIMENTS, *plugs.names("studies")}
        open_dataset(path, kind)


def test_every_table_figure_and_page_is_there(run):
    wanted = []
    for family in outputs.families():
        made = {
            "tables": outputs.tables(family, EXPERIMENTS),
            "figures": outputs.figures(family, ["folding"], asked=lambda scene: EXPERIMENTS),
        }
        for kind, forms in outputs.FORMATS.items():
            wanted += [f"{kind}/{name}.{form}" for name in made[kind] for form in forms]
    for name in (*wanted, "scores.csv", "report.html", "mlflow.db", "headline.txt"):
        assert (run.results / name).stat().st_size > 0, name


def test_the_study_of_costs_agrees_with_the_experiments(run):
    study = open_dataset(run.results / "folding/full_order/cost_reduced.nc", "cost_reduced")
    model, varied, value = (study[name].values for name in ("model", "varied", "value"))

    def at(method, what="as configured", to=""):
        (index,) = np.flatnonzero((model == method) & (varied == what) & (value == to))
        return study.isel(setting=index)

    scores = {
        "decay": "nmte_percent",
        "forced": "nmte_percent",
        "frc": "amplitude_error_median_percent",
    }
    for folder in [f"{method}/seed_0" for method in SEEDED] + [
        f"{method}/unseeded" for method in FITTED_ONCE
    ]:
        row = at(folder.split("/")[0])
        for question, score in scores.items():
            answer = open_dataset(run.results / "folding" / folder / f"{question}.nc", question)
            np.testing.assert_array_equal(
                row["error"].sel(question=question), answer["score_value"].sel(score=score)
            )
    # A fit with the settings that it has anyway is the same model.
    np.testing.assert_array_equal(
        at("ssmlearn", "order_decoder, order_dynamics", "3")["error"], at("ssmlearn")["error"]
    )
    train = open_dataset(run.results / "folding/full_order/train.nc", "trajectory")
    share = 2 * float(train["period"]) / float(train["time"][-1] - train["time"][0])
    assert float(at("ssmlearn_11", "periods", "2")["data_seconds"]) == pytest.approx(
        share * float(train["seconds"])
    )
    # A tolerance needs no new fit; a start that is trained again does.
    usual, loose, short = (
        at("split_plus"),
        at("split_plus", "rtol", "0.001"),
        at("split_plus", "start.epochs", "1"),
    )
    assert (
        float(loose["mapping_seconds"])
        == float(usual["mapping_seconds"])
        != float(short["mapping_seconds"])
    )
    assert not np.array_equal(short["error"], usual["error"])


def test_the_run_ends_with_the_headline(run):
    headline = (run.results / "headline.txt").read_text().splitlines()[0]
    assert headline in run.answer.stdout


def test_no_job_takes_more_memory_than_its_rule_asks_for(run):
    """This scene is small: what programs take, and here besides what others import."""
    lines = (run.folder / PEAKS).read_text().splitlines()
    assert len(lines) > 60
    for rule, peak in map(str.split, lines):  # MB
        kind = "full_order" if rule in ("structure", "release", "record") else "fit"
        assert 100.0 < float(peak) < HELD[kind][0], rule


def test_another_run_of_the_same_has_the_same_bytes_but_for_wall_times(run):
    """That of the walks of docs/, which asks for some of the same artefacts."""
    if "docs" not in RUNS:
        pytest.skip("test_docs.py, whose run is compared, has not run in this session")
    compared = []
    for path in sorted((RUNS["docs"] / "results/folding").rglob("*.nc")):
        other = run.results / path.relative_to(RUNS["docs"] / "results")
        if not other.exists() or path.stem == "run_times":  # times are its answer
            continue
        with xr.open_dataset(path) as mine, xr.open_dataset(other) as theirs:
            if mine.attrs["asked"] != theirs.attrs["asked"]:
                continue
            compared.append(f"{path.parent.name}/{path.stem}")
            assert mine.variables.keys() == theirs.variables.keys(), path
            for name in mine.variables:
                if "wall time" not in mine[name].attrs["long_name"]:
                    assert mine[name].identical(theirs[name]), (path, name)
    full_order = {f"full_order/{name}" for name in ("structure", "release", "train", "test", "frc")}
    assert {*full_order, "unseeded/rom", "unseeded/losses"} <= {*compared}


def test_a_second_run_has_nothing_to_do(run):
    again = run.snakemake("--cores", "2")
    assert again.returncode == 0 and "Nothing to be done" in again.stdout + again.stderr


def test_list_shows_one_rule_a_method(run):
    listed = run.snakemake("--list", start=plan).stdout.split()
    assert {f"fit_{method}" for method in SEEDED + FITTED_ONCE} <= set(listed)


def test_the_ablation_needs_no_reduced_model(run):
    jobs = set(run.planned("ablation", "--forceall"))
    assert jobs == {
        "structure",
        "release",
        "ablation_scene",
        "ablation_tables",
        "ablation_figures_of_scene",
        "ablation",
    }


def test_the_ablation_says_what_a_scene_needs_also_where_all_is_there(run):
    answer = run.snakemake("--cores", "1", "ablation")
    assert answer.returncode == 0
    assert re.search(r"^within 5 % folding needs ", answer.stdout + answer.stderr, re.MULTILINE)
    assert "ablation_scene" not in answer.stdout + answer.stderr


def test_the_length_of_those_runs_remakes_them_and_what_shows_them(run):
    path = run.folder / "longer.yaml"
    path.write_text("studies: {ablation: {decay_periods: 3}}\n")
    jobs = run.planned(overlays=(str(path),))
    assert set(jobs) == {
        "ablation_scene",
        "ablation_tables",
        "ablation_figures_of_scene",
        "report",
        "tracking",
        "crate",
        "headline",
        "all",
    }


def test_editing_a_method_runs_only_its_jobs_again(run):
    path = run.folder / "src/vibrom/methods/ssmlearn.py"
    before = path.read_text()
    path.write_text("# A comment.\n" + before)
    assert run.planned() == {}
    path.write_text(before.replace("order_dynamics: Order = 3", "order_dynamics: Order = 5"))
    jobs = run.planned()
    path.write_text(before)
    # Its variant is fitted by the same code.
    fits, asked = (
        {"fit_ssmlearn": 1, "fit_ssmlearn_11": 1},
        dict.fromkeys((*ASKED, "robustness_model"), 2),
    )
    shown = SINKS | COST | TRUST | ROBUSTNESS - {"robustness_model"}
    assert jobs == {**fits, **asked, **dict.fromkeys(shown, 1)}
    assert run.planned() == {}


def test_a_setting_of_one_method_runs_only_its_jobs_again(run):
    path = run.folder / "config/methods/split_plus.yaml"
    before = path.read_text()
    path.write_text(f"{before}settings: {{order: 2}}\n")
    jobs = run.planned()
    path.write_text(before)
    assert set(jobs) == {"fit_split_plus", *ASKED, *COST, *TRUST, *ROBUSTNESS, *SINKS}


def test_experiments_that_are_not_asked_or_read_others_are_not_in_the_shared_job(run):
    """Each is then a job of its own, or none."""
    path = run.folder / "fewer.yaml"
    path.write_text("experiments: [decay, backbone, run_times]\nstudies: null\n")
    target = "results/folding/ssmlearn/unseeded/run_times.nc"
    jobs = run.planned("--forceall", target, overlays=(str(path),))
    asked = {name for name in jobs if not name.startswith(("full_order", "fit", "rec", "rel"))}
    assert asked == {"structure", "answers", "forced", "frc", "run_times"}
    path.write_text("experiments: [decay]\nstudies: null\n")
    jobs = run.planned("--forceall", "scores", overlays=(str(path),))
    assert jobs["decay"] == len(SEEDED + FITTED_ONCE) and not ASKED & set(jobs)


def test_a_part_of_the_scene_runs_only_what_reads_it(run):
    path = run.folder / "config/scenes/folding.yaml"
    before = path.read_text()
    path.write_text(before.replace("residual: 1.0e-6", "residual: 1.0e-7"))
    timed = run.planned()
    path.write_text(before.replace("description: ", "description: now "))
    described = run.planned()
    path.write_text(before)
    assert "structure" not in timed and timed["record"] == 2
    assert described == {}


def test_the_study_of_costs_is_a_target_of_its_own(run):
    """What varies only there makes nothing else again."""
    assert run.planned("cost") == {}
    path = run.folder / "config/config.yaml"
    before = path.read_text()
    path.write_text(before.replace("patience: 0.5", "patience: 0.75"))
    jobs = run.planned("cost")
    path.write_text(before)
    assert jobs == {
        "cost_scene": 1,
        "cost_models": 1,
        "cost_tables": 1,
        "cost_figures": 1,
        "cost": 1,
    }


def test_tables_and_figures_are_targets_of_all_families(run):
    for target in ("tables", "figures"):
        assert run.planned(target) == {}
        jobs = run.planned("--forceall", target)
        made = {name.removesuffix("_of_scene") for name in jobs}
        assert {f"{family}_{target}" for family in outputs.families()} <= made
    # The study of costs reads answers that are there anyway, and asks for no others.
    asked = set(run.planned("--forceall", "cost"))
    assert "answers" in asked and not {"curves", "full_order_branches"} & asked


def test_a_new_time_stamp_on_the_shared_script_runs_nothing_again(run):
    (run.folder / "workflow/scripts/step.py").touch()
    assert run.planned() == {}


def test_a_copied_results_folder_is_what_its_settings_say(run, tmp_path):
    """Without Snakemake's records: nothing is made again, or what other settings ask for, or what
    is not the artefact that belongs there.
    """
    copied = Run(tmp_path)
    shutil.copytree(run.results, copied.results)
    assert copied.planned() == {}
    longer = tmp_path / "longer.yaml"
    longer.write_text("scene_settings: {all: {record: {periods: 4}}}\n")
    jobs = copied.planned(overlays=(str(longer),))
    assert jobs["record"] == 2 and "structure" not in jobs and "full_order_frc" not in jobs
    models = copied.results / "folding"
    shutil.copy(models / "split/seed_0/rom.nc", models / "ssmlearn/unseeded/rom.nc")
    said = copied.plan()
    assert "ssmlearn/unseeded/rom.nc: method is 'split', but 'ssmlearn' belongs here" in said
    assert re.search(r"^fit_ssmlearn +1$", said, re.MULTILINE)


# Last, as models that are made again differ in their times.
def test_damaged_artefacts_are_made_again_and_the_others_stay(run, tmp_path):
    """One that ends too early, and one that is something else."""
    train, test = (run.results / f"folding/full_order/{role}.nc" for role in ("train", "test"))
    for path in (train, test):
        shutil.copy(path, tmp_path)
    others = run.contents()
    train.write_bytes(train.read_bytes()[:1000])
    test.write_bytes(b"foreign")
    targets = ("results/folding/ssmlearn/unseeded/rom.nc", "results/folding/full_order/test.nc")
    answer = run.snakemake("--cores", "1", *targets)
    assert answer.returncode == 0, answer.stdout + answer.stderr
    for path in (train, test):
        before, after = (open_dataset(item, "trajectory") for item in (tmp_path / path.name, path))
        np.testing.assert_array_equal(after["displacement"], before["displacement"])
    made = {train, test, *(run.results / "folding/ssmlearn/unseeded").iterdir()}
    assert {name: content for name, content in others.items() if name not in made} == {
        name: content for name, content in run.contents().items() if name not in made
    }
