"""Imports go downwards only: the contracts of pyproject.toml hold."""

import subprocess
import sys
from pathlib import Path


def test_import_contracts(root):
    command = [str(Path(sys.executable).with_name("lint-imports")), "--no-cache"]
    checked = subprocess.run(command, cwd=root, capture_output=True, text=True)
    assert checked.returncode == 0, checked.stdout


def test_planning_loads_no_numerical_package():
    code = (
        "import sys; from vibrom.artefacts import provenance; "
        "from vibrom.config import settings, plugs, files; from vibrom.report import outputs; "
        "heavy = {'numpy', 'scipy', 'torch', 'xarray', 'skfem', 'numba', 'mlflow', 'pandas'}; "
        "print(*heavy & set(sys.modules))"
    )
    loaded = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    assert loaded.stdout.split() == []
