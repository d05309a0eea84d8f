import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))

import shapes  # noqa: E402

shapes.install()

from beam import beam  # noqa: E402, F401  a fixture

# What `make check` leaves out: whole workflows, trainings, long integrations, compilation.
SLOW = (
    "benchmarks",
    "bodies",
    "effects/test_elements.py",
    "effects/test_every_effect.py",
    "effects/test_in_space.py",
    "experiments/test_branches.py",
    "latent",
    "methods",
    "report",
    "solvers",
    "studies",
    "test_lanes.py",
    "test_package.py",
    "test_rollout.py",
    "test_thesis_rows.py",
    "workflow/test_bad_input.py",
    "workflow/test_docs.py",
    "workflow/test_progress.py",
    "workflow/test_faults.py",
    "workflow/test_fuzz.py",
    "workflow/test_fuzz_scenes.py",
    "workflow/test_module.py",
    "workflow/test_provenance.py",
    "workflow/test_resume.py",
    "workflow/test_small_dag.py",
    "workflow/test_tracking.py",
)


def pytest_collection_modifyitems(items):
    here = Path(__file__).parent
    gone = [name for name in SLOW if not (here / name).exists()]
    assert not gone, f"tests/conftest.py: SLOW names {gone}, which is not there"
    for item in items:
        if str(item.path.relative_to(here)).startswith(SLOW):
            item.add_marker(pytest.mark.slow)


@pytest.fixture
def one_thread():
    """What is trained adds up in one order."""
    import torch

    before = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(before)
