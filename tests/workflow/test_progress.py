"""What a run says: one line a job with what is done and left; Ctrl-C ends in one sentence."""

import os
import re
import signal
import subprocess
import sys
from functools import partial
from pathlib import Path

import pytest
from project_copy import LIMIT, ROOT, until

SNAKEFILE = """
include: "{rules}"
rule all:
    input: "second"
    localrule: True
    message: "everything is there"
rule second:
    input: "first"
    output: "second"
    message: "folding: second"
    shell: "touch begun; while [ -e slow ]; do sleep 0.1; done; touch {{output}}"
rule first:
    output: "first"
    message: "folding: first"
    shell: "touch {{output}}"
"""
LINE = re.compile(r" +(\d) of 3 +(\d+)%  (.+)  \(([\d.]+ s|\d+ min)(; about .+ left)?\)")


@pytest.fixture
def start(tmp_path):
    """Starts a run in `tmp_path`, in a group of processes of its own, as a terminal does."""
    (tmp_path / "Snakefile").write_text(
        SNAKEFILE.format(rules=ROOT / "workflow/rules/planning/progress.smk")
    )
    runs = []

    def started(*options):
        snakemake = str(Path(sys.executable).with_name("snakemake"))
        line = [snakemake, "--cores", "1", *options]
        pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT, "text": True}
        # Processes that a shell puts into the background ignore Ctrl-C, and so would this one.
        heard = partial(signal.signal, signal.SIGINT, signal.SIG_DFL)
        run = subprocess.Popen(
            line, cwd=tmp_path, start_new_session=True, preexec_fn=heard, **pipes
        )
        runs.append(run)
        return run

    yield started
    for run in runs:
        run.kill()
        run.wait()


def test_a_job_is_one_line(start):
    said, _ = start("--quiet", "host", "reason").communicate(timeout=LIMIT)
    lines = [LINE.fullmatch(line) for line in said.splitlines()]
    told = [(match[1], match[2], match[3], bool(match[5])) for match in lines if match]
    assert told == [
        ("1", "33", "folding: first", True),
        ("2", "67", "folding: second", True),
        ("3", "100", "everything is there", False),
    ]
    assert not any(word in said for word in ("Select jobs", "Execute ", "Finished jobid"))


def test_who_wants_to_know_everything_is_told(start):
    said, _ = start("--quiet", "host").communicate(timeout=LIMIT)
    assert "Finished jobid" in said and "3 of 3 steps (100%) done" in said


def test_ctrl_c_ends_in_one_sentence(start, tmp_path):
    (tmp_path / "slow").touch()
    run = start("--quiet", "host", "reason")
    until((tmp_path / "begun").exists)
    os.killpg(run.pid, signal.SIGINT)
    said, _ = run.communicate(timeout=LIMIT)
    assert run.returncode != 0 and said.count("The same command goes on from here") == 1
    assert not any(word in said for word in ("Traceback", "Error", "died with")), said
