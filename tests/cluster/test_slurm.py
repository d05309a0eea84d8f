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

import pytest
from faults import tables
from miniature import Run
from project_copy import ROOT

SCRIPT = Path(__file__).with_name("slurm.sh")
PROGRAMS = ("munged", "slurmctld", "slurmd", "sbatch", "squeue", "scancel")
LIMIT = 3600  # s, of the whole run
BY_TIMES = {"break_even", "cheapest", "run_times"}  # tables whose rows are chosen by wall times


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


def queue(form: str) -> list[str]:
    """A line a running job."""
    command = ["squeue", "--noheader", "--states=RUNNING", "--format", form]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.split()


@pytest.fixture(scope="module")
def cluster(slurm, tmp_path_factory):
    """A run through Slurm, what it printed, the memory that jobs asked for, and who was killed."""
    made = Run(tmp_path_factory.mktemp("cluster"))
    line = [str(Path(sys.executable).with_name("snakemake")), "--workflow-profile"]
    # A copy, as jobs read it long after the run began.
    overlay = shutil.copy(ROOT / "tests/workflow/small_dag.yaml", made.folder)
    line += ["profiles/slurm", "--configfile", str(overlay)]
    log, asked, killed = made.folder / "printed", set(), None
    began = time.monotonic()
    with log.open("w") as printed:
        known = [str(made.folder / "src"), os.environ.get("PYTHONPATH", "")]
        environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, known))}
        run = subprocess.Popen(
            line, cwd=made.folder, env=environment, stdout=printed, stderr=printed
        )
        try:
            while run.poll() is None and time.monotonic() - began < LIMIT:
                asked |= set(queue("%m"))
                if killed is None and (made.results / "folding/full_order/train.nc").exists():
                    for job in queue("%A")[:1]:
                        subprocess.run(["scancel", "--signal=KILL", job], check=True)
                        killed = job
                time.sleep(1.0)
        finally:
            if run.poll() is None:
                run.send_signal(signal.SIGINT)
                run.wait(60)
    text = log.read_text()
    assert run.returncode == 0, text[-6000:]
    return made, text, asked, killed


def test_a_killed_job_is_submitted_again_and_the_run_ends_well(cluster):
    made, printed, _, killed = cluster
    assert killed is not None and f"SLURM jobid {killed} " in printed
    assert "Trying to restart job" in printed
    assert (made.results / "report.html").exists()


def test_memory_comes_from_the_rules_and_small_jobs_go_together(cluster):
    made, printed, asked, _ = cluster
    assert {int(re.match(r"\d+", memory)[0]) for memory in asked} <= {*range(700, 1700)}
    jobs = len(list((made.folder / "results/logs").rglob("*.log")))
    submitted = printed.count("has been submitted with SLURM jobid")
    assert 0 < submitted < 0.6 * jobs


def test_the_tables_are_those_of_a_local_run(cluster, tmp_path):
    made, local = cluster[0], Run(tmp_path)
    answer = local.snakemake("--cores", "2")
    assert answer.returncode == 0, (answer.stdout + answer.stderr)[-6000:]
    ours, theirs = tables(made.results), tables(local.results)
    assert ours.keys() == theirs.keys() and len(ours) > 10
    for name in ours.keys() - BY_TIMES:
        assert ours[name] == theirs[name], name
