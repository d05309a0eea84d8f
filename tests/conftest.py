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
    "workflow/test_commands.py",
    "workflow/test_docs.py",
    "workflow/test_progress.py",
    "workflow/test_faults.py",
    "workflow/test_fuzz.py",
    "workflow/test_fuzz_scenes.py",
    "workflow/test_module.py",
    "workflow/test_provenance.py",
    "workflow/test_resume.py",
    "workflow/test_small_dag.py",
    "workflow/test_small_dag_again.py",
    "workflow/test_tracking.py",
)

# The two halves of `make test` run beside each other: one compiles kernels first, the other runs
# whole workflows last, which then find them compiled.
FIRST = ("effects", "models", "solvers")
LAST = (
    "workflow/test_fuzz_scenes.py",
    "workflow/test_docs.py",
    "workflow/test_faults.py",
    "workflow/test_module.py",
    "workflow/test_small_dag.py",
    "workflow/test_small_dag_again.py",
)


def pytest_collection_modifyitems(items):
    here = Path(__file__).parent
    gone = [name for name in (*SLOW, *FIRST, *LAST) if not (here / name).exists()]
    assert not gone, f"tests/conftest.py names {gone}, which is not there"
    names = {item: str(item.path.relative_to(here)) for item in items}
    for item, name in names.items():
        if name.startswith(SLOW):
            item.add_marker(pytest.mark.slow)
    items.sort(key=lambda item: names[item].startswith(LAST) - names[item].startswith(FIRST))


@pytest.fixture
def one_thread():
    """What is trained adds up in one order."""
    import torch

    before = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(before)
