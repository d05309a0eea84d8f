"""The repository, and a copy of its configuration to spoil."""

from pathlib import Path

import pytest
from project_copy import ROOT, copy


@pytest.fixture
def root() -> Path:
    return ROOT


@pytest.fixture
def project(tmp_path) -> Path:
    return copy(tmp_path)
