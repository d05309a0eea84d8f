"""Each wrong entry of the configuration is one line that names the file, the key, the value and the
cure; each right one means the same however it is written.
"""

import shutil

import pytest
import yaml
from bad_entries import BAD
from bad_scenes import SCENE
from project_copy import change
from reading import complaint, load, overlay, shown

from vibrom.config import settings
from vibrom.config.errors import SettingsError, closest
from vibrom.config.layers import MODULE

VARIANT = "config/methods/ssmlearn_11.yaml"


@pytest.mark.parametrize("case", BAD)
def test_wrong_entry_is_one_line_with_file_key_value_and_cure(project, case):
    file, key, value, says = BAD[case]
    change(project / file, key, value)
    line = complaint(project)
    named = "methods/split_plus.yaml" if case == "start outside the run" else file
    for words in (named, *says):
        assert words in line


@pytest.mark.parametrize(
    "text, says",
    [
        ("method_settings: {split: {epochs: few}}", "method_settings.split.epochs = 'few' must be"),
        ("scene_settings: {all: {time: {every: []}}}", "scene_settings.all.time.every = [] must"),
        ("scene_settings: {folding: {effects: {gravity: }}}", "folding.effects.gravity is empty"),
        ("scene_settings: {folding: {body: {width: null}}}", "folding.body.width is missing"),
        ("scene_settings: {foldin: {}}", "scene_settings.foldin = {} is no scene; did you mean"),
        ("scene_settings: 3", "scene_settings = 3 must be a block"),
        ("method_settings: {split: 3}", "method_settings.split = 3 must be a block"),
        ("seeds: [1, x]", "seeds[1] = 'x' must be a whole number"),
        ("integrator: {rtol: 1:30}", "integrator.rtol = '1:30' must be a number"),
        ("cost: {scenes: []}", "cost = {'scenes': []} is now studies.cost"),
    ],
)
def test_an_overlay_is_named_as_the_file_of_its_entry(project, tmp_path, text, says):
    line = complaint(project, overlay(tmp_path, text))
    assert "mine.yaml: " in line and says in line


def test_a_value_of_the_command_line_is_blamed_on_it(project, tmp_path):
    """Snakemake hands on nested words as text."""
    mine = overlay(tmp_path, "integrator: {rtol: 1e-3}")
    line = complaint(project, mine, integrator={"rtol": "tight"})
    assert line.startswith("--config: integrator.rtol = 'tight' must be a number")
    assert complaint(project, integrator="{rtol: 1e-3").startswith("--config: integrator = ")
    loose = load(project, mine, integrator={"atol": "1e-4"}, seeds=["3", "2e0"], studies="null")
    assert loose.integrator["rtol"] == 1e-3 and loose.integrator["atol"] == 1e-4
    assert loose.seeds == [3, 2] and loose.studies == {}


@pytest.mark.parametrize("given", [5, "mine.yaml", ["small"]])
def test_a_module_that_is_given_no_block_is_told(project, given):
    with pytest.raises(SettingsError, match="config of the module: config = .* give a block"):
        settings.load(project / "config", [], given, MODULE)


def test_overlays_merge_replace_and_remove(project, tmp_path):
    text = """
    studies: {robustness: {guards: {none: null, mine: {dissipative: 3}}, forcing: [3]}, cost: null}
    scene_settings:
      all: {effects: {modal_load: null, gravity: {}, tip_mass: null}}
      folding: {time: {every: 10}}
    method_settings: {split: {epochs: 3e0, hidden: [8]}}
    """
    run, whole = load(project, overlay(tmp_path, text)), load(project)
    guards = list(run.studies["robustness"]["guards"])
    assert guards == ["bounded", "dissipative", "dissipative_9", "mine"]
    assert run.studies["robustness"]["forcing"] == [3.0] and "cost" not in run.studies
    assert set(run.scenes["small"].effects) ^ set(whole.scenes["small"].effects) == {
        "gravity",
        "modal_load",
    }
    assert [run.scenes[name].time.every for name in ("small", "folding")] == [5, 10]
    chosen = run.methods["split"].settings
    assert chosen["epochs"] == 3 and chosen["hidden"] == [8] and type(chosen["epochs"]) is int
    later = overlay(project, "scene_settings: {all: null}\nmethod_settings: {split: null}")
    again = load(project, tmp_path / "mine.yaml", later)
    assert "modal_load" in again.scenes["small"].effects
    assert again.methods == whole.methods


def written_otherwise(value):
    """Keys in the other order, whole numbers with a point and without the other way round."""
    if isinstance(value, dict):
        return {key: written_otherwise(value[key]) for key in reversed(value)}
    if isinstance(value, list):
        return [written_otherwise(item) for item in value]
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return value
    return float(value) if isinstance(value, int) else int(value) if value % 1 == 0 else value


def test_what_means_the_same_is_the_same(project):
    """So that no job runs again for it."""
    before = shown(load(project))
    for path in [*(project / "config/scenes").glob("*.yaml"), project / VARIANT]:
        content = yaml.safe_load(path.read_text())
        other = written_otherwise(content)
        if "body" in content:
            other["body"] |= {"probes": content["body"]["probes"], "shape": "rectangle"}
            other["record"].setdefault("derivatives", "differences")
        path.write_text(yaml.safe_dump(other, sort_keys=False))
    assert shown(load(project)) == before


def test_effects_add_up_in_an_order_of_their_own(project):
    assert list(load(project).scenes["small"].effects) == [
        "inertia",
        "elasticity",
        "geometric_nonlinearity",
        "rayleigh_damping",
        "modal_load",
    ]


def test_an_effect_may_be_listed_more_than_once(project):
    stop = "{{at: [1.0, 0.01], direction: y, gap: {}, stiffness: 1.0}}"
    stops = f"[{stop.format(0.1)}, {stop.format(0.2)}]"
    text = "scene_settings: {{folding: {{effects: {{stop: {}}}}}}}"
    made = load(project, overlay(project, text.format(stops))).scenes["folding"].effects["stop"]
    assert [one["gap"] for one in made] == [0.1, 0.2] and made[0]["side"] == "positive"
    line = complaint(project, overlay(project, text.format(f"[{stop.format(-1.0)}]")))
    assert "folding.effects.stop[0].gap = -1.0 must be at least 0" in line
    line = complaint(project, overlay(project, text.format("[]")))
    assert "folding.effects.stop = [] is empty; give settings, or leave the effect out" in line


def test_a_mesh_is_a_file_beside_the_scene_and_another_one_is_another_scene(project):
    body = load(project, scenes=["perforated_beam"]).scenes["perforated_beam"].body
    mesh = project / "config/scenes/perforated_beam.msh"
    assert body["shape"] == "mesh" and body["mesh"] == str(mesh)
    mesh.write_text(mesh.read_text().replace('"tip"', '"end"'))
    other = load(project, scenes=["perforated_beam"]).scenes["perforated_beam"].body
    assert other["digest"] != body["digest"]
    mesh.unlink()
    line = complaint(project, scenes=["perforated_beam"])
    assert "body.mesh = 'perforated_beam.msh' cannot be read (No such file or directory)" in line


def test_the_repository_is_valid_with_every_overlay(root):
    plain = load(root)
    assert set(plain.scenes) == {"small", "large", "folding", "curling"}
    literal = load(root, root / "config/thesis_literal.yaml")
    assert literal.methods["split"].settings["epochs"] == 15000
    assert literal.scenes["small"].time.every == 1 and "cost" not in literal.studies
    everything = ["small", "large", "folding"]
    assert load(root, root / "config/cost_full.yaml").studies["cost"]["scenes"] == everything
    load(root, root / "tests/workflow/small_dag.yaml")
    whole = load(root, root / "config/robustness_full.yaml").studies["robustness"]
    assert plain.studies["robustness"]["scenes"] == ["folding"]
    assert whole["scenes"] == everything and whole["periods"] == 1000


def test_every_scene_file_is_valid(project):
    names = sorted(path.stem for path in (project / "config/scenes").glob("*.yaml"))
    assert len(names) > 5 and list(load(project, scenes=names).scenes) == names


@pytest.mark.parametrize("name", ["NA", "on", "1", "1.5", "beam-2_b"])
def test_names_are_names_however_they_look(project, name):
    """Of a scene, in quotes where YAML takes it for something else, and of a probe."""
    scene = project / "config/scenes" / f"{name}.yaml"
    scene.write_text((project / SCENE).read_text().replace("    tip:", f"    {name}:"))
    run = load(project, overlay(project, f"scenes: ['{name}']"))
    assert list(run.scenes[name].body["probes"]) == ["probe", name, "tip_x"]


@pytest.mark.parametrize("name", ["folding (Kopie)", "C++", "tables", "..", "a/b", "ä"])
def test_names_that_folders_and_wildcards_cannot_bear_are_refused(project, name):
    if "/" not in name:
        shutil.copy(project / SCENE, project / "config/scenes" / f"{name}.yaml")
    assert f"scenes[0] = {name!r} " in complaint(project, scenes=[name])


@pytest.mark.parametrize(
    "written, path",
    [
        ("./x", "x"),
        ("x/", "x"),
        ("a/../x", "x"),
        ("~/x", "/home/me/x"),
        ("{here}/x", "x"),
        ("/x", "/x"),
    ],
)
def test_a_folder_of_results_has_one_spelling(project, monkeypatch, tmp_path, written, path):
    monkeypatch.setenv("HOME", "/home/me")
    monkeypatch.chdir(tmp_path)
    assert load(project, results=written.format(here=tmp_path)).results == path


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


def test_some_experiments_are_evaluated_where_scenes_set_them(project, tmp_path):
    every = load(project)
    loads, curves = {"response", "random_forcing"}, {"branches", "s_curve", "resonance", "sweeps"}
    assert set(every.experiments) - set(every.asked("folding")) == loads
    assert set(every.experiments) - set(every.asked("small")) == loads | curves
    struck = load(project, overlay(tmp_path, "scenes: [struck]\nstudies: null"))
    assert set(every.experiments) - set(struck.asked("struck")) == curves
    less = overlay(tmp_path, "scene_settings: {folding: {experiments: {sweeps: null}}}")
    assert "sweeps" not in load(project, less).asked("folding")
    more = overlay(tmp_path, "scene_settings: {small: {experiments: {branches: {forcing: 1}}}}")
    assert "branches" in load(project, more).asked("small")
    wrong = overlay(tmp_path, "scene_settings: {small: {experiments: {branches: {}}}}")
    assert "experiments.branches.forcing is missing" in complaint(project, wrong)


def test_a_long_list_of_choices_stays_one_line():
    cure = closest("zzzz", [f"scene_{number}" for number in range(500)])
    assert cure.startswith("choose from scene_0, ") and cure.endswith(" more") and len(cure) < 280
    assert closest("zzzz", ["one", "two"]) == "choose from one, two"
