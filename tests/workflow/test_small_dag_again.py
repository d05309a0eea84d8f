"""The whole workflow in miniature: nothing is made twice, and an edit makes its own jobs run
again.
"""

import re
import shutil
from pathlib import Path

import numpy as np
import yaml
from miniature import EXPERIMENTS, FITTED_ONCE, SEEDED, Run
from project_copy import ROOT, command, plan

from vibrom.artefacts.data import open_dataset
from vibrom.report import outputs

ASKED = {"answers", "curves"}  # the jobs in which those are asked of a model
ROBUSTNESS = {"robustness_model", "robustness_tables", "robustness_figures_of_scene"}
COST = {"cost_models", "cost_tables", "cost_figures_of_scene"}
TRUST = {"trust_models", "trust_tables", "trust_figures"}
SINKS = {"scores", "models_tables", "models_figures", "models_figures_of_scene"}
SAME = ("folding", "again")
SMALL = ROOT / "tests/workflow/small_dag.yaml"
SINKS |= {"report", "tracking", "crate", "headline", "all"}


def test_a_second_run_has_nothing_to_do(small):
    again = small.snakemake("--cores", "2", start=plan)
    assert again.returncode == 0 and "Nothing to be done" in again.stdout + again.stderr


def test_list_shows_one_rule_a_method(small):
    listed = small.snakemake("--list", start=plan).stdout.split()
    assert {f"fit_{method}" for method in SEEDED + FITTED_ONCE} <= set(listed)


def test_the_ablation_needs_no_reduced_model(small):
    jobs = set(small.planned("ablation", "--forceall"))
    assert jobs == {
        "structure",
        "release",
        "ablation_scene",
        "ablation_tables",
        "ablation_figures_of_scene",
        "ablation",
    }


def test_the_ablation_says_what_a_scene_needs_also_where_all_is_there(small):
    answer = small.snakemake("--cores", "1", "ablation")
    assert answer.returncode == 0
    assert re.search(r"^within 5 % folding needs ", answer.stdout + answer.stderr, re.MULTILINE)
    assert "ablation_scene" not in answer.stdout + answer.stderr


def test_the_length_of_those_runs_remakes_them_and_what_shows_them(small):
    path = small.folder / "longer.yaml"
    path.write_text("studies: {ablation: {decay_periods: 3}}\n")
    jobs = small.planned(overlays=(str(path),))
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


def test_editing_a_method_runs_only_its_jobs_again_and_a_comment_or_a_new_time_stamp_none(small):
    path = small.folder / "src/vibrom/methods/ssmlearn.py"
    before = path.read_text()
    path.write_text("# A comment.\n" + before)
    (small.folder / "workflow/scripts/step.py").touch()  # all rules share it
    assert small.planned() == {}
    path.write_text(before.replace("order_dynamics: Order = 3", "order_dynamics: Order = 5"))
    jobs = small.planned()
    path.write_text(before)
    # Its variant is fitted by the same code.
    fits, asked = (
        {"fit_ssmlearn": 1, "fit_ssmlearn_11": 1},
        dict.fromkeys((*ASKED, "robustness_model"), 2),
    )
    shown = SINKS | COST | TRUST | ROBUSTNESS - {"robustness_model"}
    assert jobs == {**fits, **asked, **dict.fromkeys(shown, 1)}


def test_a_setting_of_one_method_runs_only_its_jobs_again(small):
    path = small.folder / "config/methods/split_plus.yaml"
    before = path.read_text()
    path.write_text(f"{before}settings: {{order: 2}}\n")
    jobs = small.planned()
    path.write_text(before)
    assert set(jobs) == {"fit_split_plus", *ASKED, *COST, *TRUST, *ROBUSTNESS, *SINKS}


def test_experiments_that_are_not_asked_or_read_others_are_not_in_the_shared_job(small):
    """Each is then a job of its own, or none."""
    path = small.folder / "fewer.yaml"
    path.write_text("experiments: [decay, backbone, run_times]\nstudies: null\n")
    target = "results/folding/ssmlearn/unseeded/run_times.nc"
    jobs = small.planned("--forceall", target, overlays=(str(path),))
    asked = {name for name in jobs if not name.startswith(("full_order", "fit", "rec", "rel"))}
    assert asked == {"structure", "answers", "forced", "frc", "run_times"}
    path.write_text("experiments: [decay]\nstudies: null\n")
    jobs = small.planned("--forceall", "scores", overlays=(str(path),))
    assert jobs["decay"] == len(SEEDED + FITTED_ONCE) and not ASKED & set(jobs)
    jobs = small.planned("--forceall", "tables", overlays=(str(path),))
    assert not {"full_order_forced", "full_order_frc"} & set(jobs)


def test_a_part_of_the_scene_runs_only_what_reads_it(small):
    path = small.folder / "config/scenes/folding.yaml"
    before = path.read_text()
    path.write_text(before.replace("residual: 1.0e-6", "residual: 1.0e-7"))
    timed = small.planned()
    path.write_text(before.replace("description: ", "description: now "))
    described = small.planned()
    path.write_text(before)
    assert "structure" not in timed and timed["record"] == 2
    assert described == {}


def test_the_study_of_costs_is_a_target_of_its_own(small):
    """What varies only there makes nothing else again."""
    assert small.planned("cost") == {}
    path = small.folder / "config/config.yaml"
    before = path.read_text()
    path.write_text(before.replace("patience: 0.5", "patience: 0.75"))
    jobs = small.planned("cost")
    path.write_text(before)
    assert jobs == {
        "cost_scene": 1,
        "cost_models": 1,
        "cost_tables": 1,
        "cost_figures_of_scene": 1,
        "cost": 1,
    }


def test_tables_and_figures_are_targets_of_all_families(small):
    assert small.planned("tables", "figures") == {}
    jobs = small.planned("--forceall", "tables", "figures")
    made = {name.removesuffix("_of_scene") for name in jobs}
    for target in ("tables", "figures"):
        assert {f"{family}_{target}" for family in outputs.families()} <= made
    # The study of costs reads answers that are there anyway, and asks for no others.
    asked = set(small.planned("--forceall", "cost"))
    assert "answers" in asked and not {"curves", "full_order_branches"} & asked


def test_a_copied_results_folder_is_what_its_settings_say(small, tmp_path):
    """Without Snakemake's records: nothing is made again, or what other settings ask for, or what
    is not the artefact that belongs there.
    """
    copied = Run(tmp_path)
    shutil.copytree(small.results, copied.results)
    assert copied.planned() == {}
    for method in ("split_plus", "ssmlearn_11", "pysindy_modal", "equations"):  # tell nothing more
        shutil.rmtree(copied.results / "folding" / method)
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
def test_damaged_artefacts_are_made_again_and_the_others_stay(small, tmp_path):
    """One that ends too early, and one that is something else."""
    train, test = (small.results / f"folding/full_order/{role}.nc" for role in ("train", "test"))
    for path in (train, test):
        shutil.copy(path, tmp_path)
    others = small.contents()
    train.write_bytes(train.read_bytes()[:1000])
    test.write_bytes(b"foreign")
    targets = ("results/folding/ssmlearn/unseeded/rom.nc", "results/folding/full_order/test.nc")
    answer = small.snakemake("--cores", "1", *targets)
    assert answer.returncode == 0, answer.stdout + answer.stderr
    for path in (train, test):
        before, after = (open_dataset(item, "trajectory") for item in (tmp_path / path.name, path))
        np.testing.assert_array_equal(after["displacement"], before["displacement"])
    made = {train, test, *(small.results / "folding/ssmlearn/unseeded").iterdir()}
    assert {name: content for name, content in others.items() if name not in made} == {
        name: content for name, content in small.contents().items() if name not in made
    }


def test_what_two_scenes_ask_alike_is_made_in_the_first_one(small):
    """A second scene with the same body, released elsewhere: its response from rest and the model
    from its equations are those of the first, seconds and all. Under another load they are not.
    """
    scene = (small.folder / "config/scenes/folding.yaml").read_text()
    (small.folder / "config/scenes/again.yaml").write_text(scene)
    block = yaml.safe_load(SMALL.read_text())["scene_settings"]
    path = small.folder / "twice.yaml"

    def ask(**experiments):
        again = block["folding"] | {"releases": {"test": {"step": 300}}, "experiments": experiments}
        overlay = {"scenes": ["folding", "again"], "scene_settings": {"again": again}}
        path.write_text(yaml.safe_dump(overlay))

    names = ("full_order/frc", "equations/unseeded/rom", "equations/unseeded/losses")
    first, second = ([f"results/{scene}/{name}.nc" for name in names] for scene in SAME)
    ask()
    made = small.snakemake("--cores", "2", *second[:2], overlays=(str(path),))
    assert made.returncode == 0, made.stdout + made.stderr
    for there, here in zip(first, second):
        before, after = (
            open_dataset(small.folder / file, Path(file).stem) for file in (there, here)
        )
        assert before.equals(after) and after.attrs["scene"] == "again", here
    asked = small.planned("--forceall", second[0], overlays=(str(path),))
    ask(frc={"forcing": 50.0})
    other = small.planned("--forceall", second[0], overlays=(str(path),))
    assert (asked["full_order_frc"], other["full_order_frc"]) == (2, 1)


def test_figures_of_an_earlier_run_go_where_a_run_does_not_ask_for_them(small):
    asked = [name for name in EXPERIMENTS if name != "response"]
    path = small.folder / "without.yaml"
    path.write_text(yaml.safe_dump({"experiments": asked}))
    figures, rule = small.results / "figures", "models_figures_of_scene"
    alone = ("--forcerun", rule, "--allowed-rules", rule, "--", "results/figures/decay_folding.svg")
    before = {file.name for file in figures.iterdir()}
    for more in ([str(path)], []):
        given = ("--cores", "2", "--configfile", str(SMALL), *more, *alone)
        made = command(small.folder, *given, PYTHONPATH=str(small.folder / "src"))
        assert made.returncode == 0, made.stdout + made.stderr
        after = {file.name for file in figures.iterdir()}
        gone = {f"response_folding.{form}" for form in ("svg", "pdf", "png")} if more else set()
        assert before - after == gone
