"""The command as a user sees it: one line for a wrong entry, exit code not zero, finished artefacts
as they were.
"""

import subprocess
import sys

import pytest
import yaml
from bad_entries import BAD
from project_copy import change, plan

from vibrom.__main__ import check
from vibrom.config.command_line import overlays
from vibrom.config.errors import ConfigError

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
# What Snakemake itself says before it reads the Snakefile.
CHATTER = ("Using workflow specific profile",)


@pytest.mark.parametrize("case", PROMISED)
def test_command_ends_with_one_line(project, case):
    finished = project / "results/folding/full_order/train.nc"
    finished.parent.mkdir(parents=True)
    finished.write_bytes(b"finished")
    file, key, value, says = BAD[case]
    change(project / file, key, value)
    answer = plan(project, "--cores", "2")
    lines = answer_lines(answer)
    assert answer.returncode != 0 and len(lines) == 1 and lines[0].startswith("vibrom: ")
    for words in (file, *says):
        assert words in lines[0]
    assert finished.read_bytes() == b"finished"


def answer_lines(answer) -> list[str]:
    printed = (answer.stdout + answer.stderr).splitlines()
    return [line for line in printed if line.strip() and not line.startswith(CHATTER)]


@pytest.mark.parametrize(
    "content, says",
    [
        (b"scenes: [small\n", "line 2 is not YAML (did not find expected ',' or ']'); correct it"),
        (b"results: caf\xe9\n", "file is not UTF-8 text; save it as UTF-8"),
    ],
)
def test_a_broken_main_file(project, content, says):
    (project / "config/config.yaml").write_bytes(content)
    answer = plan(project, "-n")
    assert answer.returncode != 0
    assert answer_lines(answer) == [f"vibrom: config/config.yaml: {says}"]


def test_the_command_line_is_blamed_for_its_values(project):
    answer = plan(project, "-n", "--config", "integrator={rtol: tight}")
    (line,) = answer_lines(answer)
    assert answer.returncode != 0
    assert line.startswith("vibrom: --config: integrator.rtol = 'tight' must be a number")


def test_a_workflow_runs_its_own_package_or_none(project):
    (project / "src/vibrom").mkdir(parents=True)
    (line,) = answer_lines(plan(project, "-n"))
    assert line.startswith("vibrom: ") and "and not this checkout's" in line


DEEP = "a: " + "[" * 3000 + "]" * 3000


@pytest.mark.parametrize(
    "content, says",
    [
        ("# größe\nscenes: [small]".encode("latin-1"), "file is not UTF-8 text; save it as UTF-8"),
        ("scenes: [small]".encode("utf-16"), "file is not UTF-8 text; save it as UTF-8"),
        (DEEP.encode(), "line 1 is nested more than 50 deep; nothing here needs that"),
        (None, "file cannot be read (No such file or directory); check the name"),
    ],
)
def test_an_overlay_that_snakemake_cannot_read_is_one_line(project, content, says):
    if content is not None:
        (project / "overlay.yaml").write_bytes(content)
    answer = plan(project, "-n", "--configfile", "overlay.yaml")
    assert answer.returncode == 1
    assert answer_lines(answer) == [f"vibrom: overlay.yaml: {says}"]


def test_the_check_says_what_is_wrong(project):
    (project / "overlay.yaml").write_text("scenes: [smal]\n")
    answer = subprocess.run(
        [sys.executable, "-m", "vibrom", "check", "overlay.yaml"],
        cwd=project,
        capture_output=True,
        text=True,
    )
    assert answer.returncode == 1 and answer.stdout == ""
    assert answer.stderr.startswith("vibrom: overlay.yaml: scenes[0] = 'smal' is no scene")
    assert answer.stderr.count("\n") == 1


@pytest.mark.parametrize(
    "words, found",
    [
        (["--cores", "2", "--configfile", "a", "b", "-n", "c"], ["a", "b"]),
        (["a", "--configfiles=b", "c", "--cores=1"], ["b", "c"]),
        (["--config", "configfile=a", "b"], []),
        (["--configfile"], []),
    ],
)
def test_overlays_of_a_command(words, found):
    assert [str(path) for path in overlays(words)] == found


def test_the_check_says_what_a_fine_configuration_asks_for(project):
    (project / "overlay.yaml").write_text("scenes: [large]\nstudies: {cost: null}\n")
    printed = check(project / "config", [project / "overlay.yaml"]).splitlines()
    assert printed[0] == "The configuration is fine."
    assert printed[1].split() == ["scenes", "large"]
    assert not any("cost" in line for line in printed)


@pytest.mark.parametrize(
    "block, says",
    [
        ({"body": {"clamped": ["lefd"]}}, "body.clamped[0] = 'lefd' is no group of "),
        (
            {"body": {"probes": {"tip": {"at": "tipp", "direction": "y"}}}},
            "body.probes.tip.at = 'tipp' is no group of the mesh; did you mean 'tip'?",
        ),
        (
            {"effects": {"follower_load": {"edge": "hol", "pressure": 1.0}}},
            "effects.follower_load.edge = 'hol' is no boundary of the body",
        ),
    ],
)
def test_the_check_looks_for_groups_in_the_mesh(project, block, says):
    overlay = {"scenes": ["perforated_beam"], "scene_settings": {"perforated_beam": block}}
    (project / "overlay.yaml").write_text(yaml.safe_dump(overlay))
    with pytest.raises(ConfigError) as error:
        check(project / "config", [project / "overlay.yaml"])
    line = str(error.value)
    assert line.startswith(f"scene perforated_beam: {says}") and "\n" not in line
