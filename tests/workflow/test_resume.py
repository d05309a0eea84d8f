"""A run that was killed is taken over by the next; one that is going on is left alone."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from project_copy import ROOT, command, until

# `first` is made at once; `second` takes its time once, as long as the file `slow` is there.
SNAKEFILE = """
from pathlib import Path
from types import SimpleNamespace
SETTINGS = SimpleNamespace(results="results")
include: "{rules}"
rule second:
    input: "first"
    output: "second"
    shell: "touch begun; while [ -e slow ]; do sleep 0.1; done; touch {{output}}"
rule first:
    output: "first"
    shell: "touch {{output}}"
"""


@pytest.fixture
def running(tmp_path):
    """A run that is under way in `tmp_path`."""
    (tmp_path / "Snakefile").write_text(
        SNAKEFILE.format(rules=ROOT / "workflow/rules/planning/resume.smk")
    )
    (tmp_path / "slow").touch()
    line = [str(Path(sys.executable).with_name("snakemake")), "--cores", "1"]
    run = subprocess.Popen(line, cwd=tmp_path, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    until((tmp_path / "begun").exists)
    yield run
    (tmp_path / "slow").unlink(missing_ok=True)
    run.kill()
    run.wait()


def test_killed_run_is_resumed(running, tmp_path):
    running.send_signal(signal.SIGKILL)
    running.wait()
    (tmp_path / "slow").unlink()
    made = (tmp_path / "first").stat().st_mtime_ns
    again = command(tmp_path, "--cores", "1", "--rerun-incomplete")
    assert again.returncode == 0, again.stderr
    assert (tmp_path / "second").exists() and (tmp_path / "first").stat().st_mtime_ns == made


def test_the_number_of_a_dead_run_that_another_process_has_now_is_no_obstacle(running, tmp_path):
    """In containers every run is process 1. What its jobs were writing is removed."""
    running.send_signal(signal.SIGKILL)
    running.wait()
    (tmp_path / "slow").unlink()
    partial = tmp_path / "results/folding/.rom.nc.abc.partial"
    partial.parent.mkdir(parents=True)
    partial.touch()
    note = tmp_path / ".snakemake/running"
    node, number, started = note.read_text().split()
    times = note.stat().st_atime, note.stat().st_mtime
    note.write_text(f"{node} {os.getpid()} {started}\n")
    os.utime(note, times)
    again = command(tmp_path, "--cores", "1", "--rerun-incomplete")
    assert again.returncode == 0, again.stderr
    assert (tmp_path / "second").exists() and not partial.exists()


def test_run_under_way_is_left_alone(running, tmp_path):
    other = command(tmp_path, "--cores", "1", "--rerun-incomplete")
    assert other.returncode != 0 and "cannot be locked" in other.stdout + other.stderr
    assert running.poll() is None


TOLD = """
import sys
from snakemake.scheduling.job_scheduler import JobScheduler
JobScheduler._schedule_reevalutation = lambda self, delay: print("looks again")
from snakemake.cli import main
main()
"""


def test_jobs_on_this_machine_are_not_counted_by_the_second(project):
    """With a limit of jobs a second, every job would start a timer that starts others."""
    (project / "one.yaml").write_text("scenes: [small]\n")
    target = "results/small/full_order/structure.nc"
    answer = subprocess.run(
        [sys.executable, "-c", TOLD, "--cores", "1", target, "--configfile", "one.yaml"],
        cwd=project,
        capture_output=True,
        text=True,
        env=os.environ | {"PYTHONPATH": str(ROOT / "src")},
    )
    assert answer.returncode == 0, answer.stderr[-3000:]
    assert (project / target).is_file() and "looks again" not in answer.stdout
