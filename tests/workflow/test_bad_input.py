"""The command as a user sees it: one line for a wrong entry, exit code not zero, finished artefacts
as they were.
"""

from concurrent.futures import ThreadPoolExecutor

import pytest
from bad_entries import BAD
from project_copy import change, command, copy

PROMISED = [
    "unknown effect",
    "unknown method",
    "unknown scene key",
    "unknown element",
    "negative stiffness",
    "unknown edge",
    "train is test",
    "zero time step",
    "repeated seeds",
]
# What Snakemake itself says before it reads the Snakefile, and when a file is laid over the
# configuration.
CHATTER = ("Using workflow specific profile", "Config file ")


@pytest.fixture(scope="module")
def answers(tmp_path_factory):
    """What the command says to each of the promised cases."""

    def ask(case):
        folder = copy(tmp_path_factory.mktemp("case"))
        finished = folder / "results/folding/full_order/train.nc"
        finished.parent.mkdir(parents=True)
        finished.write_bytes(b"finished")
        file, key, value, _ = BAD[case]
        change(folder / file, key, value)
        return command(folder, "--cores", "2"), finished.read_bytes()

    with ThreadPoolExecutor(2) as pool:
        return dict(zip(PROMISED, pool.map(ask, PROMISED), strict=True))


@pytest.mark.parametrize("case", PROMISED)
def test_command_ends_with_one_line(answers, case):
    answer, finished = answers[case]
    lines = [
        line
        for line in (answer.stdout + answer.stderr).splitlines()
        if line.strip() and not line.startswith(CHATTER)
    ]
    assert answer.returncode != 0 and len(lines) == 1 and lines[0].startswith("vibrom: ")
    for words in (BAD[case][0], *BAD[case][3]):
        assert words in lines[0]
    assert finished == b"finished"


def test_broken_yaml_in_the_main_file(project):
    (project / "config/config.yaml").write_text("scenes: [small\n")
    answer = command(project, "-n")
    lines = [
        line
        for line in (answer.stdout + answer.stderr).splitlines()
        if not line.startswith(CHATTER)
    ]
    assert answer.returncode != 0 and lines == [
        "vibrom: config/config.yaml: line 2 is not YAML (did not find expected ',' or ']'); correct it"
    ]
