"""What every study promises, whichever are in the folder: the constants that rules are made of name
what there is, and the settings of the configuration are those of the class.
"""

import dataclasses
import importlib.util

import pytest
from project_copy import ROOT

from vibrom import studies
from vibrom.config import plugs
from vibrom.config.settings import load
from vibrom.studies import KINDS, Case, Study, StudyError, plug

NAMES = plugs.names("studies")
# What there is of the full order besides answers to experiments.
RECORDS = {"release", "train", "test"}


def test_the_folder_holds_studies():
    assert {"ablation", "cost", "robustness"} <= set(NAMES)


@pytest.mark.parametrize("name", NAMES)
def test_constants_are_read_from_the_text_as_they_are(name):
    kind, read = plug(name), plugs.constants("studies", name)
    for constant in ("jobs", "reads", "experiments", "settings", "parts"):
        assert read[constant] == getattr(kind, constant), constant


@pytest.mark.parametrize("name", NAMES)
def test_jobs_name_artefacts_and_have_what_does_them(name):
    kind = plug(name)
    assert kind.jobs and set(kind.jobs) <= set(KINDS)
    # Of the full order's folder there is one file of a name.
    folders = [(job == "model", artefact) for job, artefact in kind.jobs.items()]
    assert len(set(folders)) == len(folders)
    for job in kind.jobs:
        own = getattr(kind, f"of_{job}") is not getattr(Study, f"of_{job}")
        assert own != (job in kind.parts), job
    for module in kind.parts.values():
        assert importlib.util.find_spec(f"vibrom.{module}") is not None
        assert callable(importlib.import_module(f"vibrom.{module}").made)


@pytest.mark.parametrize("name", NAMES)
def test_what_is_read_is_made_by_a_rule(name):
    kind, experiments = plug(name), set(plugs.names("experiments"))
    assert set(kind.experiments) <= experiments and set(kind.reads) <= set(kind.jobs)
    for job, needs in kind.reads.items():
        for need in needs:
            folder, _, artefact = need.rpartition("/")
            assert folder in ("", "full_order"), need
            assert artefact in (experiments if folder == "" else experiments | RECORDS), need
            assert folder or job != "scene", f"{need}: a scene has no answers of fitted models"


@pytest.mark.parametrize("name", NAMES)
def test_every_setting_belongs_to_a_job_and_the_configuration_has_them_all(name):
    kind = plug(name)
    fields = {field.name for field in dataclasses.fields(kind)} - {"scenes"}
    named = kind.settings or dict.fromkeys(kind.jobs, tuple(fields))
    assert set(named) == set(kind.jobs)
    assert {field for needs in named.values() for field in needs} == fields
    block = load(ROOT / "config").studies[name]
    for needs in named.values():
        made = studies.study(name, {key: block[key] for key in needs})
        assert all(getattr(made, key) is not None for key in needs)


def test_a_setting_that_is_none_or_wrong_is_one_line():
    with pytest.raises(StudyError, match="studies.ablation.repeat is no setting; did you mean"):
        studies.study("ablation", {"repeat": 3})
    with pytest.raises(StudyError, match="studies.ablation.repeats: Expected `int` >= 1"):
        studies.study("ablation", {"repeats": 0})


def test_a_scene_without_an_experiment_that_a_study_needs_is_one_line():
    case = Case({"experiments": {}}, None)
    with pytest.raises(StudyError, match="no experiments.forced, which the study needs; add it"):
        case.question("forced")
