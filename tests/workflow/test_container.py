"""The container file without an engine: each of its steps in a folder that holds what it copies;
and that a container, CI and `make` install the same pinned packages.
"""

import os
import re
import shutil
import subprocess
import sys
from fnmatch import fnmatch

import pytest
from project_copy import ROOT

STEPS = re.findall(r"^([A-Z]+) (.*)$", (ROOT / "envs/Containerfile").read_text(), re.MULTILINE)
# In place of Python, pip and uv: notes what it is asked for. What Python is asked to compute is
# computed.
STAND_IN = """#!/bin/sh
[ "$1" != -c ] || exec {python} "$@"
echo "$(basename "$0") $*" >> {log}
[ "$1" != -V ] || echo Python 3.12
if [ "$1 $2" = "-m venv" ]; then
    mkdir -p .venv/bin
    for name in python uv snakemake; do cp "$0" .venv/bin/$name; done
fi
"""


@pytest.fixture
def image(tmp_path):
    """The folder of the image after COPY, and what `make` would call there instead of Python."""
    ignored = (ROOT / ".dockerignore").read_text().split()

    def left_out(folder, names):
        top = os.path.samefile(folder, ROOT)
        return [
            name
            for name in names
            if name == "__pycache__" or top and any(fnmatch(name, each) for each in ignored)
        ]

    shutil.copytree(ROOT, tmp_path / "vibrom", ignore=left_out)
    programs = tmp_path / "bin"
    programs.mkdir()
    program = programs / "python3"
    program.write_text(STAND_IN.format(python=sys.executable, log=tmp_path / "asked"))
    program.chmod(0o755)
    return tmp_path


def asked(image, line, code=0):
    """What a step asks of Python, pip and uv."""
    (image / "asked").write_text("")
    path = f"{image / 'bin'}:{os.environ['PATH']}"
    answer = subprocess.run(
        ["sh", "-c", line],
        cwd=image / "vibrom",
        env=os.environ | {"PATH": path},
        capture_output=True,
        text=True,
    )
    assert answer.returncode == code, answer.stdout + answer.stderr
    return (image / "asked").read_text().splitlines()


def test_its_steps_are_those_that_are_tried_here():
    assert [name for name, _ in STEPS] == ["FROM", "RUN", "WORKDIR", "COPY", "RUN", "CMD"]
    assert STEPS[3][1] == ". ." and STEPS[4][1] == "make env" and STEPS[5][1] == '["make"]'
    packages = re.search(r"--no-install-recommends (.*?) &&", STEPS[1][1])[1].split()
    # What make and envs/make.sh call, and what Debian's python3 comes without.
    assert {"make", "python3", "python3-venv"} <= {*packages}
    subprocess.run(["sh", "-n", "-c", STEPS[1][1]], check=True)


@pytest.mark.skipif(shutil.which("apt-get") is None, reason="no apt-get: another system")
def test_its_packages_are_debians():
    packages = re.search(r"--no-install-recommends (.*?) &&", STEPS[1][1])[1].split()
    known = subprocess.run(["apt-cache", "pkgnames"], capture_output=True, text=True).stdout
    if "python3-venv" not in known.split():
        pytest.skip("apt has no lists here: apt-get update")
    assert {*packages} <= {*known.split()}


def test_nothing_of_this_machine_is_copied(image):
    there = {path.name for path in (image / "vibrom").iterdir()}
    assert {"Makefile", "Snakefile", "envs", "src", "config", "pyproject.toml"} <= there
    assert not there & {".git", ".venv", ".snakemake", "results"}


def test_its_environment_is_the_lock_checked_by_hash_and_made_once(image):
    calls = asked(image, STEPS[4][1])
    installs = [line for line in calls if " install " in line]
    locked = [line for line in installs if "--require-hashes -r envs/" in line]
    (own,) = [line for line in installs if line not in locked]
    assert own.endswith("--no-deps --no-build-isolation -e .")
    assert [line.split()[-1] for line in locked] == ["envs/uv.txt", "envs/requirements.txt"]
    assert asked(image, STEPS[4][1]) == []
    # The command of the container makes nothing again, and starts the run.
    assert asked(image, "make") == ["snakemake --cores 2"]


def test_ci_runs_in_the_environment_of_the_same_lock(image):
    """`.ci/run` is `make test`, which makes that environment first."""
    assert (image / "vibrom/.ci/run").read_text().splitlines()[-1] == "exec make test"
    plan = subprocess.run(
        ["make", "--dry-run", "test"], cwd=image / "vibrom", capture_output=True, text=True
    )
    assert plan.stdout.splitlines()[0] == "sh envs/make.sh python3", plan.stdout
