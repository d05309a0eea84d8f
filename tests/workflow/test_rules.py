"""The rules: as Snakemake's own checks want them, with one environment for all."""

import re
import tomllib

import yaml
from project_copy import ROOT, command

CONDA = {"torch": "pytorch", "matplotlib": "matplotlib-base", "msgspec": "msgspec-python"}
NOT_INSIDE = {"snakemake", "vibrom"}  # it runs the jobs; they import the checkout itself


def test_snakemake_has_nothing_to_say_about_the_rules():
    answer = command(ROOT, "--lint", PYTHONPATH=str(ROOT / "src"))
    assert answer.returncode == 0, answer.stdout + answer.stderr


def test_slurm_gets_all_that_ends_a_run_together():
    """The profile names rules, some of which are made from what tables and figures are there."""
    listed = set(command(ROOT, "--list", PYTHONPATH=str(ROOT / "src")).stdout.split())
    profile = yaml.safe_load((ROOT / "profiles/slurm/profile.yaml").read_text())
    named = dict(item.split("=") for item in profile["groups"])
    assert named.keys() <= listed
    made = {name for name in listed if re.search("_(tables|figures)(_of_scene.*)?$", name)}
    assert len(made) > 8 and made <= {name for name in named if named[name] == "results"}


def test_the_environment_of_conda_has_the_packages_of_the_project():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    extras = [
        item for extra in ("train", "workflow") for item in project["optional-dependencies"][extra]
    ]
    wanted = {re.match(r"[A-Za-z0-9-]+", item)[0] for item in project["dependencies"] + extras}
    environment = yaml.safe_load((ROOT / "envs/vibrom.yaml").read_text())
    listed = {re.match(r"[A-Za-z0-9-]+", item)[0] for item in environment["dependencies"]}
    named = {CONDA.get(name, name).lower() for name in wanted - NOT_INSIDE}
    assert listed - {"python"} == named
