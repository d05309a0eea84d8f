"""The repository, a copy of its configuration to spoil, and the whole workflow in miniature."""

from pathlib import Path

import pytest
from miniature import Run
from project_copy import ROOT, copy, warm


@pytest.fixture
def root() -> Path:
    return ROOT


@pytest.fixture
def project(tmp_path) -> Path:
    return copy(tmp_path)


@pytest.fixture(scope="session")
def small(tmp_path_factory):
    """All that is shown is made in forks of a warm process, and the rest by the plain command."""
    made = Run(tmp_path_factory.mktemp("small"))
    with warm(made.folder) as start:
        answer = made.snakemake(
            "--cores", "2", "report", "scores", "tables", "figures", start=start
        )
    assert answer.returncode == 0, (answer.stdout + answer.stderr)[-6000:]
    answer = made.snakemake("--cores", "2")
    assert answer.returncode == 0, (answer.stdout + answer.stderr)[-6000:]
    made.answer = answer
    return made
