"""The small run through a Slurm of one node, with a job that is killed, against a local run.

`make cluster` runs it, as root and with Debian's packages slurm-wlm and munge; elsewhere it is
skipped. It takes some minutes, most of which jobs wait in the queue.
"""

import os
import re
import shutil
import signal
import subprocess
import sys
import time
from importlib.util import find_spec
from pathlib import Path
from typing import NamedTuple

import pytest
from faults import tables
from miniature import Run
from project_copy import ROOT, change

from vibrom.config import settings
from vibrom.config.memory import mem_mb

SCRIPT = Path(__file__).with_name("slurm.sh")
PROGRAMS = ("munged", "slurmctld", "slurmd", "sbatch", "squeue", "scancel")
STALLED = 1800  # s without a sign of progress; how long the whole takes depends on the machine
BY_TIMES = {"break_even", "cheapest", "run_times"}  # tables whose rows are chosen by wall times
ASKING, ASKS = "equations", {"threads": 2, "runtime": 30}  # a method, what its file asks for
KINDS = {  # of jobs that are submitted alone, for their memory
    "fit_ssmlearn_wild": "fit",
    "full_order_frc_wild": "full_order_answer",
    "fit_equations_wild": "equations",
    "trust_models_wild": "study_models",
}
# Notes what Slurm is asked for, and, where nothing is to start, what it says to that.
SBATCH = """#!/bin/sh
printf '%s\\n' "$*" >> {log}
[ -z "$SBATCH_TEST" ] || {{ {program} --test-only "$@" 2>> {log}; exit 1; }}
exec {program} "$@"
"""


def missing() -> str:
    """Why there is no Slurm to run in."""
    if os.environ.get("VIBROM_CLUSTER") != "1":
        return "`make cluster` runs it"
    if gone := [name for name in PROGRAMS if shutil.which(name) is None]:
        return f"no {gone[0]}: apt-get install slurm-wlm munge"
    if find_spec("snakemake_executor_plugin_slurm") is None:
        return "no snakemake-executor-plugin-slurm: install envs/cluster.txt"
    return "" if os.geteuid() == 0 else "only root can start Slurm's daemons"


pytestmark = pytest.mark.skipif(bool(missing()), reason=missing())


@pytest.fixture(scope="module")
def slurm(tmp_path_factory):
    folder = str(tmp_path_factory.mktemp("slurm"))
    subprocess.run(["sh", SCRIPT, "start", folder], check=True)
    yield
    subprocess.run(["sh", SCRIPT, "stop", folder], check=True)


def running() -> list[str]:
    """Numbers of jobs; none where the controller is too busy to say."""
    command = ["squeue", "--noheader", "--states=RUNNING", "--format", "%A"]
    return subprocess.run(command, capture_output=True, text=True).stdout.split()


def asking(folder) -> Run:
    """A copy of the workflow in which a method asks for resources of its own."""
    made = Run(folder)
    change(made.folder / f"config/methods/{ASKING}.yaml", "resources", ASKS)
    return made


class Submitted(NamedTuple):
    """A run through Slurm."""

    made: Run
    line: list[str]
    environment: dict[str, str]
    calls: Path  # a line for each call of sbatch

    def asked(self, rule: str, option: str) -> set[str]:
        """The values of an option of sbatch, for the jobs of a rule or group."""
        lines = [text for text in self.calls.read_text().splitlines() if f"rule_{rule}" in text]
        assert lines, rule
        found = [re.search(rf"{option}[ =](\S+)", text) for text in lines]
        return {one[1] for one in found if one}


@pytest.fixture(scope="module")
def submitted(slurm, tmp_path_factory):
    """Ready to run."""
    made = asking(tmp_path_factory.mktemp("cluster"))
    line = [str(Path(sys.executable).with_name("snakemake")), "--workflow-profile"]
    # A copy, as jobs read it long after the run began.
    overlay = shutil.copy(ROOT / "tests/workflow/small_dag.yaml", made.folder)
    line += ["profiles/slurm", "--configfile", str(overlay)]
    calls, programs = made.folder / "calls", made.folder / "bin"
    programs.mkdir()
    text = SBATCH.format(log=calls, program=shutil.which("sbatch"))
    (programs / "sbatch").write_text(text)
    (programs / "sbatch").chmod(0o755)
    known = [str(made.folder / "src"), os.environ.get("PYTHONPATH", "")]
    environment = os.environ | {
        "PYTHONPATH": os.pathsep.join(filter(None, known)),
        "PATH": f"{programs}:{os.environ['PATH']}",
        "SBATCH_TEST": "",
    }
    return Submitted(made, line, environment, calls)


@pytest.fixture(scope="module")
def cluster(submitted):
    """What the whole run printed, and which job was killed."""
    made, log, killed = submitted.made, submitted.made.folder / "printed", None
    seen, since, before = None, time.monotonic(), set()
    with log.open("w") as printed:
        both = {"stdout": printed, "stderr": printed}
        run = subprocess.Popen(submitted.line, cwd=made.folder, env=submitted.environment, **both)
        try:
            while run.poll() is None and time.monotonic() - since < STALLED:
                now = set(running())
                sign = log.stat().st_size, len(list(made.results.rglob("*"))), now
                if sign != seen:
                    seen, since = sign, time.monotonic()
                # One that has just begun: it takes seconds to start.
                begun = now - before
                if not killed and begun and (made.results / "folding/full_order/train.nc").exists():
                    job = min(begun)
                    done = subprocess.run(["scancel", "--signal=KILL", job])
                    killed = job if done.returncode == 0 else None
                before = now
                time.sleep(1.0)
        finally:
            if run.poll() is None:
                run.send_signal(signal.SIGINT)
                run.wait()
    text = log.read_text()
    assert run.returncode == 0, text[-6000:]
    return text, killed


def test_a_killed_job_is_submitted_again_and_the_run_ends_well(submitted, cluster):
    printed, killed = cluster
    assert killed is not None and f"SLURM jobid {killed} " in printed
    assert "Trying to restart job" in printed
    assert (submitted.made.results / "report.html").exists()


def test_memory_time_and_threads_come_from_the_rules(submitted, cluster):
    overlay = ROOT / "tests/workflow/small_dag.yaml"
    scene = settings.load(ROOT / "config", [overlay]).scenes["folding"].to_builtins()
    for rule, kind in KINDS.items():
        assert submitted.asked(rule, "--mem") == {str(mem_mb(scene, kind))}, rule
    assert submitted.asked(f"fit_{ASKING}_wild", "-t") == {str(ASKS["runtime"])}
    assert submitted.asked(f"fit_{ASKING}_wild", "--cpus-per-task") == {str(ASKS["threads"])}
    assert submitted.asked("fit_ssmlearn_wild", "-t") == {"60"}  # minutes, of the profile
    assert submitted.asked("fit_ssmlearn_wild", "--cpus-per-task") == {"1"}
    assert submitted.asked("fit_ssmlearn_wild", "--gpus") == set()


def test_small_jobs_go_together(submitted, cluster):
    jobs = len(list((submitted.made.folder / "results/logs").rglob("*.log")))
    count = cluster[0].count("has been submitted with SLURM jobid")
    assert 0 < count < 0.6 * jobs


def test_a_fit_on_a_gpu_asks_for_one(submitted, cluster):
    """Slurm, whose node has one in name, says when it would start, and starts nothing."""
    target = "results/folding/split/seed_0/rom.nc"
    run = subprocess.run(
        [*submitted.line, "--config", "device=cuda", "--", target],
        cwd=submitted.made.folder,
        env=submitted.environment | {"SBATCH_TEST": "1"},
        capture_output=True,
        text=True,
    )
    assert submitted.asked("fit_split_", "--gpus") == {"1"}, run.stdout + run.stderr
    assert re.search(r"Job \d+ to start at", submitted.calls.read_text())


def test_the_tables_are_those_of_a_local_run(submitted, cluster, tmp_path):
    made, local = submitted.made, asking(tmp_path)
    with (tmp_path / "printed").open("w") as printed:
        both = {"stdout": printed, "stderr": printed}
        line = [submitted.line[0], "--cores", "2", *submitted.line[3:]]
        known = submitted.environment | {"PYTHONPATH": str(local.folder / "src")}
        answer = subprocess.run(line, cwd=local.folder, env=known, **both)
    assert answer.returncode == 0, (tmp_path / "printed").read_text()[-6000:]
    ours, theirs = tables(made.results), tables(local.results)
    assert ours.keys() == theirs.keys() and len(ours) > 10
    for name in ours.keys() - BY_TIMES:
        assert ours[name] == theirs[name], name
