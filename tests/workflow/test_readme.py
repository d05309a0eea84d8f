"""README as a newcomer follows it: its files are written as they stand, its commands are run, and
what they promise is there.
"""

import re
import shutil
import subprocess

import pandas as pd
import pytest
from project_copy import ROOT, command, copy

README = (ROOT / "README.md").read_text()
# `some/file.py`:  and then the file in a fenced block
FILE = re.compile(r"`([\w./]+\.(?:py|yaml))`:\n\n```\w+\n(.*?)```", re.DOTALL)
OVERLAY = "config/mine.yaml"  # names all that the sections add
COMMAND = re.compile(r"^(snakemake|make)\b(.*?)(?:\s+#.*)?$", re.MULTILINE)
BLOCK = re.compile(r"```sh\n(.*?)```", re.DOTALL)


def commands(text):
    """The lines of shell blocks that run snakemake or make."""
    lines = "\n".join(BLOCK.findall(text))
    return [f"{name}{rest}".strip() for name, rest in COMMAND.findall(lines)]


def shown():
    """Commands in README, and in the headers of the configuration's files."""
    found = set(commands(README))
    for path in [*(ROOT / "config").glob("*.yaml"), ROOT / "Snakefile"]:
        for line in path.read_text().splitlines():
            comment = re.match(r"#.*?\b(snakemake --cores .*)$", line)
            if comment:
                found.add(re.split(r"\s{2,}", comment[1].strip().rstrip(".`)"))[0])
    return sorted(found)


@pytest.fixture(scope="module")
def followed(tmp_path_factory):
    """A copy of the repository with everything that README adds, after the small run of it."""
    folder = copy(tmp_path_factory.mktemp("readme"), "src", "tests/workflow")
    for name, text in FILE.findall(README):
        assert not (folder / name).exists(), f"{name} is there already"
        (folder / name).write_text(text)
    small = str(folder / "tests/workflow/small_dag.yaml")
    answer = command(
        folder,
        "--cores",
        "2",
        "--configfile",
        small,
        OVERLAY,
        PYTHONPATH=str(folder / "src"),
    )
    assert answer.returncode == 0, (answer.stdout + answer.stderr)[-6000:]
    return folder


def table(folder, name):
    """A table of the run; no text is taken for a missing value."""
    return pd.read_csv(folder / f"results/tables/{name}.csv", keep_default_na=False)


def test_every_section_that_adds_something_has_its_files():
    sections = re.findall(r"### Add an? ([\w ]+)\n(.*?)(?=\n##)", README, re.DOTALL)
    assert {name.split()[0] for name, _ in sections} == {
        "method", "variant", "effect", "scene", "experiment", "study", "table", "figure",
    }  # fmt: skip
    for name, text in sections:
        assert FILE.search(text), f"Add a {name}: no file in it"


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


@pytest.mark.parametrize("line", [line for line in shown() if line.startswith("snakemake")])
def test_every_snakemake_command_that_is_shown_is_one(tmp_path, line):
    """As it is typed; without running jobs, as most take minutes."""
    folder = copy(tmp_path, "src")
    (folder / "config/mine.yaml").write_text("scenes: [small]\n")
    words = line.split()[1:]
    quiet = ["--list"] if "--list" in words else [*words, "--dry-run", "--quiet"]
    answer = command(folder, *quiet, PYTHONPATH=str(folder / "src"))
    assert answer.returncode == 0, (answer.stdout + answer.stderr)[-3000:]


@pytest.mark.parametrize("line", [line for line in shown() if line.startswith("make")])
def test_every_target_of_make_that_is_shown_is_one(tmp_path, line):
    shutil.copy(ROOT / "Makefile", tmp_path)
    answer = subprocess.run(
        ["make", "--dry-run", *line.split()[1:]], cwd=tmp_path, capture_output=True, text=True
    )
    assert answer.returncode == 0, answer.stderr
