"""Each wrong entry of the configuration is one line that names the file, the key, the value and the
cure.
"""

import pytest
import yaml
from bad_entries import BAD, SCENE
from project_copy import change

from vibrom.config import settings
from vibrom.config.files import SettingsError, merge, numbers


def load(project, *overlays):
    config = yaml.safe_load((project / "config/config.yaml").read_text())
    for overlay in overlays:
        config = merge(config, yaml.safe_load(overlay.read_text()))
    return settings.load(
        config, folder=project / "config", schemas=project / "workflow/schemas", files=overlays
    )


def complaint(project, *overlays) -> str:
    with pytest.raises(SettingsError) as caught:
        load(project, *overlays)
    return str(caught.value)


@pytest.mark.parametrize("case", BAD)
def test_wrong_entry_is_one_line_with_file_key_value_and_cure(project, case):
    file, key, value, says = BAD[case]
    change(project / file, key, value)
    line = complaint(project)
    assert "\n" not in line
    named = "methods/split_plus.yaml" if case == "start outside the run" else file
    for words in (named, *says):
        assert words in line


def test_an_overlay_is_named_as_the_file_of_its_entry(project, tmp_path):
    overlay = tmp_path / "mine.yaml"
    overlay.write_text("method_settings: {split: {epochs: few}}\n")
    line = complaint(project, overlay)
    assert "mine.yaml" in line and "method_settings.split.epochs = 'few'" in line


@pytest.mark.parametrize(
    "text, says",
    [
        ("a: 1\na: 2\n", "line 2 is not YAML ('a' is given twice"),
        ("a: [1\n", "is not YAML"),
        ("- 1\n", "holds no"),
    ],
)
def test_text_that_is_no_configuration(project, text, says):
    (project / SCENE).write_text(text)
    line = complaint(project)
    assert says in line and "folding.yaml" in line and "\n" not in line


def test_the_repository_is_valid_with_every_overlay(root):
    plain = load(root)
    assert set(plain.scenes) == {"small", "large", "folding"}
    literal = load(root, root / "config/thesis_literal.yaml")
    assert literal.methods["split"]["settings"]["epochs"] == 15000
    assert literal.scenes["small"]["time"]["every"] == 1
    assert load(root, root / "config/cost_full.yaml").cost["scenes"] == [
        "small",
        "large",
        "folding",
    ]
    load(root, root / "tests/workflow/small_dag.yaml")
    whole = load(root, root / "config/stability_full.yaml")
    assert (
        plain.stability["scenes"] == ["folding"]
        and whole.stability["scenes"] == ["small", "large", "folding"]
        and whole.stability["periods"] == 1000
    )


def test_every_scene_file_is_valid(project):
    names = sorted(path.stem for path in (project / "config/scenes").glob("*.yaml"))
    change(project / "config/config.yaml", "scenes", names)
    assert {
        "small",
        "cantilever_unlocked",
        "clamped_clamped",
        "shallow_arch",
        "tip_mass_stop",
    } <= set(load(project).scenes)


def test_numbers_without_a_dot_or_sign_are_numbers():
    assert numbers({"a": ["1e-8", "104.0e9", "left"], "b": {"c": "3E+2"}}) == {
        "a": [1e-8, 104.0e9, "left"],
        "b": {"c": 300.0},
    }


def test_seed_folders_and_starts(root):
    plain = load(root)
    assert plain.seed_folders("split") == ["seed_0", "seed_1", "seed_2"]
    assert plain.seed_folders("ssmlearn") == ["unseeded"]
    assert plain.seed_folders("ssmlearn_11") == ["unseeded"]
    assert [plain.kind_of(name) for name in ("ssmlearn", "ssmlearn_11", "pysindy_modal")] == [
        "ssmlearn",
        "ssmlearn",
        "pysindy_modal",
    ]
    assert plain.start_of("split_plus", "seed_1") == ("split", "seed_1")
    assert plain.start_of("split", "seed_1") is None
