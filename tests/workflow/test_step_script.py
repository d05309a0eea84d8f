"""The script behind every rule: arguments, logs, and which errors are one line."""

import errno
import os
import runpy
import subprocess
import sys
import types
from pathlib import Path

import numpy as np
import psutil
import pytest
from project_copy import ROOT

from vibrom.artefacts.data import DataError
from vibrom.artefacts.hardware import check_memory


class Named(dict):
    """Stands for Snakemake's named lists."""


def job(tmp_path, step, **params):
    inputs = Named(source="in.nc", sources=["a.nc", "b.nc"])
    return types.SimpleNamespace(
        input=inputs,
        output=Named(target="out.nc"),
        params=Named(step=step, **params),
        log=[str(tmp_path / "log")],
        rule="rule",
        threads=1,
        scriptdir=str(ROOT / "workflow/scripts"),
    )


@pytest.fixture
def run(root, tmp_path, monkeypatch):
    """run(function, **params): the script with this function as its step."""

    def start(function, **params):
        module = types.ModuleType("vibrom.steps.probe")
        module.run = function
        monkeypatch.setitem(sys.modules, "vibrom.steps.probe", module)
        runpy.run_path(
            str(root / "workflow/scripts/step.py"),
            init_globals={"snakemake": job(tmp_path, "probe", **params)},
        )

    return start


def test_names_become_keyword_arguments(run):
    seen = {}
    run(
        lambda **given: seen.update(given),
        seed=None,
        provenance={"source_digest": "x", "versions": "{}"},
    )
    provenance = seen.pop("provenance")
    assert seen == {
        "source": "in.nc",
        "sources": ["a.nc", "b.nc"],
        "target": "out.nc",
        "seed": None,
    }
    assert provenance["source_digest"] == "x" and '"xarray"' in provenance["versions"]


def test_output_goes_to_terminal_and_log(run, tmp_path, capfd):
    run(lambda **given: print("half way", file=sys.stderr))
    assert "half way" in capfd.readouterr().err and "half way" in (tmp_path / "log").read_text()


SCRIPT = """
import runpy, sys, types
module = types.ModuleType("vibrom.steps.probe")
module.run = lambda **given: print("0.1 \\u2013 0.3")
sys.modules["vibrom.steps.probe"] = module
job = types.SimpleNamespace(
    input={{}}, output={{}}, params={{"step": "probe"}}, log=[{log!r}], rule="rule", threads=1,
    scriptdir={folder!r},
)
runpy.run_path({folder!r} + "/step.py", init_globals={{"snakemake": job}})
"""


def test_a_terminal_of_ascii_is_no_error(tmp_path):
    text = SCRIPT.format(log=str(tmp_path / "log"), folder=str(ROOT / "workflow/scripts"))
    ascii_only = {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}
    answer = subprocess.run(
        [sys.executable, "-c", text], capture_output=True, env=os.environ | ascii_only
    )
    assert answer.stdout == b"0.1 ? 0.3\n" and answer.returncode == 0
    assert (tmp_path / "log").read_text(encoding="utf-8") == "0.1 \u2013 0.3\n"


BARE = "import sys; sys.path = [path for path in sys.path if not path.endswith('src')]\n"


def test_an_environment_without_the_package_runs_the_one_of_the_workflow(tmp_path):
    text = SCRIPT.format(log=str(tmp_path / "log"), folder=str(ROOT / "workflow/scripts"))
    text = text.replace('"0.1 \\u2013 0.3"', "sys.modules['vibrom'].__file__")
    without = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    command = [sys.executable, "-P", "-c", BARE + text]
    answer = subprocess.run(command, capture_output=True, text=True, env=without, cwd=tmp_path)
    assert answer.stdout.strip() == str(ROOT / "src/vibrom/__init__.py"), answer.stderr


def fail(error):
    def step(**given):
        raise error

    return step


@pytest.mark.parametrize(
    "error, says",
    [
        (
            DataError("in.nc: not a readable netCDF file;\ndelete it and run again"),
            "vibrom: in.nc: not a readable netCDF file; delete it and run again",
        ),
        (
            OSError(errno.ENOSPC, "No space left on device", "results/x.nc"),
            "vibrom: results/x.nc: no space left; free some or",
        ),
    ],
)
def test_own_errors_are_one_line(run, tmp_path, capfd, error, says):
    with pytest.raises(SystemExit) as stopped:
        run(fail(error))
    printed = capfd.readouterr().err.strip()
    assert stopped.value.code == 1
    assert printed.startswith(says) and "\n" not in printed
    assert printed in (tmp_path / "log").read_text()


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full, a disk without space")
def test_what_went_wrong_is_said_where_the_log_cannot_be_written(run, tmp_path, capfd):
    (tmp_path / "log").symlink_to("/dev/full")
    with pytest.raises(SystemExit, match="no space left"):
        run(fail(DataError("train.nc: is damaged")))
    assert capfd.readouterr().err == "vibrom: train.nc: is damaged\n"


def test_a_bug_keeps_its_traceback(run, capfd):
    with pytest.raises(SystemExit) as stopped:
        run(fail(ZeroDivisionError("bug")))
    assert stopped.value.code == 1
    assert "Traceback" in capfd.readouterr().err


def test_another_checkouts_package_is_not_run(run, tmp_path, capfd, monkeypatch):
    """Where a workflow has a src/vibrom beside it, that one runs or none."""
    (tmp_path / "src/vibrom").mkdir(parents=True)
    monkeypatch.setattr(sys.modules[__name__], "ROOT", tmp_path)
    with pytest.raises(SystemExit):
        run(lambda **given: pytest.fail("ran"))
    printed = capfd.readouterr().err.strip()
    assert "would run, and not this checkout's" in printed and "\n" not in printed
    assert printed.endswith("(see README.md)") and str(tmp_path / "src/vibrom") in printed


ORPHAN = """
import sys, time
sys.path[:0] = [{tests!r}]
import pathlib, runpy, types
from test_step_script import job
module = types.ModuleType("vibrom.steps.probe")
module.run = lambda **given: (print("running", flush=True), time.sleep(600))
sys.modules["vibrom.steps.probe"] = module
given = {{"snakemake": job(pathlib.Path({folder!r}), "probe")}}
runpy.run_path({script!r}, init_globals=given)
"""
PARENT = """
import subprocess, sys
job = subprocess.Popen([sys.executable, "-c", sys.argv[1]])
print(job.pid, flush=True)
job.wait()
"""


@pytest.mark.skipif(sys.platform != "linux", reason="asks Linux for it")
def test_a_job_ends_with_the_run_that_started_it(root, tmp_path):
    """Killed outright, a run cannot end its jobs, and the next run would start them again."""
    code = ORPHAN.format(
        tests=str(root / "tests/workflow"),
        folder=str(tmp_path),
        script=str(root / "workflow/scripts/step.py"),
    )
    parent = subprocess.Popen(
        [sys.executable, "-c", PARENT, code], stdout=subprocess.PIPE, text=True
    )
    orphan = psutil.Process(int(parent.stdout.readline()))
    assert parent.stdout.readline() == "running\n"
    parent.kill()
    parent.wait()
    assert psutil.wait_procs([orphan], timeout=300) == ([orphan], [])


def test_a_package_that_cannot_be_written_to_has_its_compiled_code_elsewhere(run, monkeypatch):
    monkeypatch.setenv("NUMBA_CACHE_DIR", "")
    monkeypatch.delenv("NUMBA_CACHE_DIR")
    monkeypatch.setattr("os.access", lambda path, mode: False)
    run(lambda **given: None)
    assert os.environ["NUMBA_CACHE_DIR"] == str(Path(".snakemake/numba").absolute())


def test_memory_that_is_not_there_is_one_line(run, capfd):
    def step(**given):
        check_memory(1e18, "a motion", "lower periods")

    with pytest.raises(SystemExit):
        run(step)
    printed = capfd.readouterr().err.strip()
    assert printed.startswith("vibrom: a motion takes 9.31e+08 GiB of memory, and")
    with pytest.raises(SystemExit):
        run(lambda **given: np.empty(10**17))
    assert capfd.readouterr().err.startswith("vibrom: not enough memory (Unable to allocate")


def test_no_space_left_keeps_the_finished_artefact(run, tmp_path, capfd, monkeypatch):
    from vibrom.artefacts import data

    path = tmp_path / "losses.nc"
    losses = data.label(
        data.xr.Dataset(
            {"train_total": data.variable("epoch", [1.0], "1", "loss")},
            {"epoch": data.variable("epoch", [1], "1", "epoch")},
        ),
        "losses",
        scene="small",
        method="split",
    )
    data.save_dataset(losses, path)
    finished = path.read_bytes()

    def full(*paths):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr("vibrom.artefacts.files.os.replace", full)
    with pytest.raises(SystemExit):
        run(lambda **given: data.save_dataset(losses, path))
    printed = capfd.readouterr().err.strip()
    assert (
        str(path) in printed
        and "No space left" in printed
        and "free space" in printed
        and "\n" not in printed
    )
    assert path.read_bytes() == finished and list(tmp_path.glob(".*")) == []
