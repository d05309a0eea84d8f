"""The library alone: what it asks for, and what it can do without the packages of the workflow."""

import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
EXTRAS = (
    "torch",
    "snakemake",
    "mlflow",
    "pysindy",
    "matplotlib",
    "jinja2",
    "rich",
)
WITHOUT = f"import sys; sys.modules.update(dict.fromkeys({EXTRAS}))\n"  # None: cannot be imported
MODEL = """
import numpy as np
from scenes import THESIS, body
from vibrom import effects
from vibrom.bodies import space
from vibrom.experiments import experiment
from vibrom.methods.equations import Equations
from vibrom.models.rom import rom_from_dataset
from vibrom.models.rollout import Integrator, rollout
from vibrom.models.training import Training

beam = effects.assemble(space.build(body(cells=[3, 1])), THESIS)
fitted = Equations(order=5).learn(Training((), term=beam))
rom = rom_from_dataset(fitted.to_dataset())
run = rollout(rom, 0.5 * rom.reach[None], np.linspace(0.0, 1.0, 5)[None], Integrator())
experiment("branches", {"forcing": 1.0})
print(run.outcome[0])
"""


def python(script, *paths):
    code = "".join(f"sys.path.insert(0, {str(path)!r})\n" for path in paths)
    return subprocess.run(
        [sys.executable, "-c", WITHOUT + code + script], capture_output=True, text=True
    )


def test_a_model_is_made_stored_opened_and_asked_without_any_extra():
    answer = python(MODEL, ROOT / "tests", ROOT / "src")
    assert answer.stdout.split() == ["ok"], answer.stderr


@pytest.mark.parametrize(
    ("module", "extra"),
    [("latent.learner", "train"), ("report.page", "workflow"), ("tracking", "workflow")],
)
def test_what_is_missing_is_said_with_the_extra_that_has_it(module, extra):
    answer = python(f"import vibrom.{module}", ROOT / "src")
    assert f"which is not installed; install vibrom[{extra}]" in answer.stderr


def test_what_is_installed_is_said_by_one_command():
    answer = python("from vibrom.__main__ import report\nprint(report())", ROOT / "src")
    for word in ("rectangle", "geometric_nonlinearity", "equations", "branches", "robustness"):
        assert word in answer.stdout
    assert "can be trained: no: install vibrom[train]" in answer.stdout


def test_a_wheel_of_the_source_distribution_holds_every_file_of_the_package(tmp_path):
    """As `python -m build` makes them, one of the other."""
    project = tmp_path / "project"  # a copy, as a build leaves files beside the sources
    left = shutil.ignore_patterns("*.egg-info", "__pycache__")  # others may compile at this moment
    shutil.copytree(ROOT / "src", project / "src", ignore=left)
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, project)
    script = f"import setuptools.build_meta as made; made.build_sdist({str(tmp_path)!r})"
    subprocess.run([sys.executable, "-c", script], cwd=project, check=True, capture_output=True)
    sources = next(tmp_path.glob("*.tar.gz"))
    command = [sys.executable, "-m", "pip", "wheel", "-q", "--no-deps", "--no-build-isolation"]
    subprocess.run([*command, "-w", tmp_path, sources], check=True, capture_output=True)
    with zipfile.ZipFile(next(tmp_path.glob("*.whl"))) as wheel:
        inside = {name for name in wheel.namelist() if name.startswith("vibrom/")}
    source = ROOT / "src"
    there = {
        str(path.relative_to(source))
        for path in (source / "vibrom").rglob("*")
        if path.is_file() and "__pycache__" not in path.parts
    }
    assert inside == there
