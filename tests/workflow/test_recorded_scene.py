"""The file of a recorded scene: complete with defaults, beside scenes with a body; a wrong entry is
one line.
"""

import pytest

from vibrom.config import settings
from vibrom.config.errors import SettingsError

SCENE = """
kind: recorded
description: "a decay"
recordings:
  - {file: decay.csv, role: train}
  - {file: decay.csv, role: test, begin: 1.0}
"""
OVERLAY = """
scenes: [folding, measured]
scene_settings: {all: {body: {cells: [8, 2]}, time: {every: 1}}}
"""


@pytest.fixture
def scene(project, monkeypatch):
    """Writes the scene's file as `change` makes it, and loads the configuration."""
    (project / "decay.csv").write_text("t,x\n0,1\n1,2\n")
    monkeypatch.chdir(project)
    overlay = project / "mine.yaml"
    overlay.write_text(OVERLAY)

    def load(change=lambda text: text):
        (project / "config/scenes/measured.yaml").write_text(change(SCENE))
        return settings.load(project / "config", [overlay])

    return load


def test_what_is_laid_over_all_scenes_is_for_those_with_a_body(scene):
    found = scene()
    made = found.scenes["measured"]
    assert made.preparation.filter == "regularised" and made.time_unit == "s"
    assert found.scenes["folding"].body["cells"] == [8, 2]
    assert found.modules_of("measured") == []


def test_it_takes_part_in_what_it_can_answer(scene):
    """No forcing is known, so nothing that reads a forced answer is asked."""
    assert set(scene().asked("measured")) == {"reconstruction", "decay", "backbone", "eigenvalues"}
    driven = scene(lambda text: text + "experiments: {forced: {forcing: 1.0}}\n")
    assert "forced" in driven.asked("measured")
    assert all("measured" not in study["scenes"] for study in scene().studies.values())


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("kind: recorded", "kind: measured", "kind = 'measured' is no kind of scene; choose from"),
        ("decay.csv, role: train", "dekay.csv, role: train", "recordings[0].file = 'dekay.csv' is"),
        ("role: train", "role: trial", "recordings[0].role = 'trial' is not known"),
        ("recordings:", "recordings:\n  - {file: decay.csv, role: forced}", "needs the `signal`"),
        ("role: train", "role: train, signal: u", "is left alone; remove it"),
        ("role: train", "role: test", "has no recording with the role train"),
        ("description:", "body: {}\ndescription:", "is no setting; choose from kind, name"),
        ("kind: recorded", "kind: recorded\ntime_unit: h", "time_unit = 'h' is not known"),
        (
            "kind: recorded",
            "kind: recorded\npreparation: {filter: none, lag: -1}",
            "preparation.lag = -1 must be greater than 0",
        ),
    ],
)
def test_a_wrong_entry_is_one_line(scene, old, new, says):
    with pytest.raises(SettingsError) as caught:
        scene(lambda text: text.replace(old, new))
    line = str(caught.value)
    assert says in line and "config/scenes/measured.yaml" in line and "\n" not in line
