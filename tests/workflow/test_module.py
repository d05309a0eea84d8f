"""Another workflow uses this one as docs/walks/reuse.md says: a module, with its own settings."""

import os
import re
import shutil
import subprocess

import pandas as pd
import pytest
from project_copy import ROOT, copy, plan, warm

PATHS = {"PYTHONPATH": str(ROOT / "src")}
CONFIG = """
scenes: [folding]
methods: [modal_projection]
experiments: [decay]
studies: {cost: null, robustness: null, ablation: null, trust: null}
scene_settings:
  all:
    body: {cells: [8, 2], probes: {probe: {at: [0.5, 0.0]}}}
    releases: {train: {forcing: 600.0, step: 500}, test: {forcing: 600.0, step: 400}}
    record: {periods: 2}
    time: {steps_per_period: 200, every: 2}
"""
PAGE = (ROOT / "docs/walks/reuse.md").read_text()
SNAKEFILE = re.search("```python\n(configfile.*?)```", PAGE, re.DOTALL)[1]


def project(folder, more="", renamed=""):
    """A workflow of somebody else."""
    text = SNAKEFILE.replace("/path/to/vibrom", str(ROOT))
    text = text.replace('config["beams"]\n', f'config["beams"]\n{more}').replace(
        " as beam_*", renamed
    )
    (folder / "Snakefile").write_text(text)
    block = "".join(f"  {line}\n" for line in CONFIG.strip().splitlines())
    (folder / "mine.yaml").write_text(f"beams:\n{block}other: 1\n")
    return folder


def test_another_workflow_runs_this_one_under_other_names(tmp_path):
    folder = project(tmp_path, renamed=" as beam_*")
    with warm(folder, ROOT / "src") as start:
        answer = start(folder, "--cores", "2", "beam_scores")
    assert answer.returncode == 0, (answer.stdout + answer.stderr)[-3000:]
    scores = pd.read_csv(folder / "results/scores.csv", keep_default_na=False)
    assert set(scores["method"]) == {"full_order", "modal_projection"}
    assert (folder / "results/folding/full_order/train.nc").is_file()


@pytest.mark.parametrize(
    "more, renamed, place",
    [("", "", "results/scores.csv"), ('    prefix: "beams"\n', " as beam_*", "beams/results")],
)
def test_names_and_places_may_be_kept_or_changed(tmp_path, more, renamed, place):
    folder = project(tmp_path, more, renamed)
    target = "beam_scores" if renamed else "scores"
    answer = plan(folder, "--cores", "1", "-n", target, **PATHS)
    assert answer.returncode == 0, (answer.stdout + answer.stderr)[-3000:]
    assert place in answer.stdout


def test_a_project_has_its_own_configuration(tmp_path):
    """The files of config/ copied and edited, as a deployed workflow has them."""
    folder = project(tmp_path)
    os.mkdir(folder / "config")
    own = (ROOT / "config/config.yaml").read_text()
    (folder / "config/config.yaml").write_text(own)
    answer = plan(folder, "--cores", "1", "-n", "scores", **PATHS)
    assert answer.returncode != 0
    assert "vibrom: config of the module: scenes[0] = 'folding'" in answer.stderr
    for name in ("scenes", "methods"):
        shutil.copytree(ROOT / "config" / name, folder / "config" / name)
    answer = plan(folder, "--cores", "1", "-n", "scores", **PATHS)
    assert answer.returncode == 0, answer.stderr


def test_results_may_lie_in_another_folder(tmp_path):
    """`--directory`: the configuration that is here, results there."""
    (tmp_path / "mine.yaml").write_text("scenes: [small]\n")
    answer = plan(
        ROOT, "--cores", "1", "-n", "--quiet", "--directory", str(tmp_path), "scores", **PATHS
    )
    assert answer.returncode == 0, answer.stdout + answer.stderr


HOSTED = """
configfile: "config/config.yaml"

module vibrom:
    snakefile: github("somebody/vibrom", path="workflow/Snakefile", branch="main")
    config: config

use rule * from vibrom
"""  # as snakedeploy writes it


def test_a_hosted_repository_is_deployed(tmp_path):
    """Git is told that the repository lies here."""
    host, here = tmp_path / "host", tmp_path / "here"
    host.mkdir()
    copy(host)
    shutil.copytree(ROOT / "config", here / "config")
    (here / "workflow").mkdir()
    (here / "workflow/Snakefile").write_text(HOSTED)
    settings = tmp_path / "gitconfig"
    settings.write_text(
        f'[url "file://{host}"]\n    insteadOf = https://github.com/somebody/vibrom\n'
        "[user]\n    name = one\n    email = one@localhost\n"
    )
    known = {"GIT_CONFIG_GLOBAL": str(settings), "XDG_CACHE_HOME": str(tmp_path / "cache")}
    for words in (["init", "-q", "-b", "main"], ["add", "."], ["commit", "-q", "-m", "all"]):
        subprocess.run(["git", *words], cwd=host, env=os.environ | known, check=True)
    target = "results/small/full_order/structure.nc"
    answer = plan(here, "--cores", "1", "--", target, **PATHS, **known)
    assert answer.returncode == 0, (answer.stdout + answer.stderr)[-3000:]
    assert (here / target).is_file()
