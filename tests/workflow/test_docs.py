"""The walks of docs/ as a newcomer follows them: their files are written as they stand, what they
add is run, their scripts too, and what they promise is there. test_commands.py runs the commands.
"""

import os
import re
import subprocess
import sys

import numpy as np
import pandas as pd
import pytest
import yaml
from pages import FILE, blocks, lines, walk
from project_copy import ROOT, RUNS, command, copy, warm

WALKS = ("method", "effect", "experiment", "study", "measurement")
# All that the walks add, at once.
OVERLAY = """
scenes: [folding, sprung, ruler]
methods: [ssmlearn, ssmlearn_7, one_mode]
experiments: [reconstruction, decay, frc, work, measured_response, measured_forcing]
studies:
  ablation: {scenes: [sprung]}
  cost: null
  robustness: null
  trust: null
  loose_integration: {scenes: [folding], rtol: [1.0e-2, 1.0e-4]}
"""


@pytest.fixture(scope="module")
def followed(tmp_path_factory):
    """A copy of the repository with everything that the walks add, after the small run of it."""
    folder = copy(tmp_path_factory.mktemp("docs"), "src", "tests/workflow")
    for name, text in FILE.findall("\n".join(map(walk, WALKS))):
        assert not (folder / name).exists(), f"{name} is there already"
        (folder / name).write_text(text)
    measure(folder)
    ruler = yaml.safe_load((folder / "config/ruler.yaml").read_text())["scene_settings"]
    (folder / "config/mine.yaml").write_text(OVERLAY + yaml.safe_dump({"scene_settings": ruler}))
    own = ("--configfile", str(folder / "tests/workflow/small_dag.yaml"), "config/mine.yaml")
    with warm(folder) as start:
        made = start(folder, "scores", "--cores", "2", *own)
    shown = command(
        folder, "tables", "report", "--cores", "2", *own, PYTHONPATH=str(folder / "src")
    )
    for answer in (made, shown):
        assert answer.returncode == 0, (answer.stdout + answer.stderr)[-6000:]
    RUNS["docs"] = folder
    return folder


def measure(folder):
    """The scene of measured motion: its files, and what `vibrom record` makes of them."""
    for name, text in FILE.findall(walk("measurement")):
        (folder / name).write_text(text)
    for line in lines(blocks(walk("measurement"), "sh")[0]):
        program, *words = line.split()
        start = [sys.executable, *([] if program == "python" else ["-m", program])]
        environment = os.environ | {"PYTHONPATH": str(folder / "src")}
        answer = subprocess.run(
            [*start, *words], cwd=folder, capture_output=True, text=True, env=environment
        )
        assert answer.returncode == 0, answer.stderr[-3000:]


def table(folder, name):
    """A table of the run; no text is taken for a missing value."""
    return pd.read_csv(folder / f"results/tables/{name}.csv", keep_default_na=False)


@pytest.mark.parametrize("name", WALKS)
def test_every_walk_has_its_files(name):
    assert FILE.search(walk(name))


@pytest.mark.parametrize("method", ["one_mode", "ssmlearn_7"])
def test_the_new_methods_are_evaluated_in_the_new_scene_too(followed, method):
    decay = table(followed, "decay")
    for scene in ("folding", "sprung"):
        row = decay[(decay["case"] == scene) & (decay["method"] == method)]
        assert row["outcome"].tolist() in (["ok"], ["left_range"]), decay


def test_the_new_effect_stiffens_the_body(followed):
    """Without the spring the first frequency falls: 2 kN/m against 3 EI/L^3 = 10.4 kN/m."""
    ablation = table(followed, "ablation")
    row = ablation[(ablation["case"] == "sprung") & (ablation["left_out"] == "linear_spring")]
    change = float(row["omega_1_rad_per_s_change_percent"].item())
    assert -12.0 < change < -5.0


def test_the_new_experiment_has_scores_a_table_and_a_place_on_the_page(followed):
    scores = pd.read_csv(followed / "results/scores.csv", keep_default_na=False)
    work = scores[scores["experiment"] == "work"]
    assert set(work["method"]) >= {"one_mode", "ssmlearn_7"} and set(work["unit"]) == {"percent"}
    assert set(table(followed, "work")["method"]) >= {"one_mode", "ssmlearn_7"}
    assert "Scores of the experiment work" in (followed / "results/report.html").read_text()


def test_the_new_study_has_its_table_and_its_figure(followed):
    rows = table(followed, "loose_integration")
    assert set(rows["method"]) == {"ssmlearn", "ssmlearn_7", "one_mode"}
    assert sorted(set(rows["rtol"].astype(float))) == [1e-4, 1e-2]
    for form in ("svg", "pdf", "png"):
        assert (followed / f"results/figures/loose_integration.{form}").stat().st_size > 1000
    page = (followed / "results/report.html").read_text()
    assert 'id="loose_integration"' in page and 'data-plot="loose_integration"' in page


def test_the_measured_scene_is_predicted_and_what_needs_a_body_is_skipped(followed):
    """The script's noise of 1 % is in the decay that it is compared with, filtered."""
    decay = table(followed, "decay").set_index(["case", "method"])
    assert decay.loc[("ruler", "ssmlearn"), "outcome"] == "ok"
    assert float(decay.loc[("ruler", "ssmlearn"), "nmte_percent"]) < 1.0
    assert decay.loc[("ruler", "one_mode"), "outcome"] == "skipped"
    curve = table(followed, "measured_response").set_index(["case", "method"])
    error = curve.loc[("ruler", "ssmlearn"), "amplitude_error_median_percent"]
    assert float(error) < 3.0  # the averaged equation of the script is as good as that
    assert "folding" not in curve.index
    driven = table(followed, "measured_forcing").set_index(["case", "method"])
    assert float(driven.loc[("ruler", "ssmlearn"), "nmte_percent"]) < 4.0
    for name in ("slow_motion", "measured_response", "measured_forcing"):
        assert (followed / f"results/figures/{name}_ruler.svg").stat().st_size > 1000
        assert not (followed / f"results/figures/{name}_folding.svg").exists()


def test_the_script_about_measured_motion_runs_without_snakemake(followed):
    script = re.search(r"## In Python.*?```python\n(.*?)```", walk("measurement"), re.DOTALL)[1]
    answer = subprocess.run(
        [sys.executable, "-c", script],
        cwd=followed,
        capture_output=True,
        text=True,
        env=os.environ | {"PYTHONPATH": str(followed / "src")},
    )
    assert answer.returncode == 0, answer.stderr[-3000:]
    errors = [float(value) for value in re.findall(r": ([\d.]+) %", answer.stdout)]
    assert len(errors) == 2 and max(errors) < 3.0
    assert (followed / "ruler.nc").stat().st_size > 1000


def test_the_script_about_a_fitted_model_runs_and_predicts_as_the_scores_say(followed):
    """Its lines, one after the other; its folding beam is the small one here."""
    script = "\n".join(re.findall(r"```python\n(.*?)```", walk("python"), re.DOTALL))
    script = script.replace("Integrator()", "Integrator(rtol=1.0e-4, atol=1.0e-6)")  # as the run's
    answer = subprocess.run(
        [sys.executable, "-c", script],
        cwd=followed,
        capture_output=True,
        text=True,
        env=os.environ | {"PYTHONPATH": str(followed / "src"), "MPLBACKEND": "agg"},
    )
    assert answer.returncode == 0, answer.stderr[-3000:]
    decay = table(followed, "decay")
    row = decay[(decay["case"] == "folding") & (decay["method"] == "ssmlearn")]
    printed = float(re.search(r"decay: ([\d.]+) %", answer.stdout)[1])
    # Three decimals are printed.
    np.testing.assert_allclose(printed, float(row["nmte_percent"].item()), rtol=0.0, atol=6e-4)
    assert (followed / "curve.png").stat().st_size > 1000


def test_the_documentation_is_built_without_a_word(tmp_path):
    """As `make docs` does it: every link and every page of the reference, without a network."""
    recipe = subprocess.run(["make", "-n", "docs"], cwd=ROOT, capture_output=True, text=True).stdout
    command = re.search(r".*-m mkdocs.*", recipe)[0].replace(".venv/bin/python", sys.executable)
    answer = subprocess.run(
        ["sh", "-c", f"{command} -d {tmp_path / 'site'}"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        env=os.environ | {"PYTHONPATH": str(ROOT / "src")},
    )
    assert answer.returncode == 0 and not answer.stdout + answer.stderr
    page = (tmp_path / "site/reference/experiments.html").read_text()
    assert "times the damped first frequency" in page
    fetched = re.findall(r"<(?:script|link|img)[^>]+(?:src|href)=\"(?:https?:)?//[^\"]+", page)
    assert not [tag for tag in fetched if "canonical" not in tag]
