"""What was made from what: read back by the library of the format, and compared with the files."""

import hashlib
from pathlib import Path

import pytest
from rocrate.rocrate import ROCrate
from small_run import PROVENANCE

from vibrom.steps import crate as step


@pytest.fixture(scope="module")
def folder(small):
    """Of the artefacts: the one above all of their scenes."""
    return Path(small.paths[0]).parents[2]


@pytest.fixture(scope="module")
def crate(small, folder):
    shown = folder / "scores.csv"
    shown.write_text("scene,method\n")
    step.run(
        artefacts=small.paths,
        shown=[str(shown)],
        crate=str(folder / "ro-crate-metadata.json"),
        provenance=PROVENANCE,
    )
    return ROCrate(str(folder))


def below(paths, folder) -> set[str]:
    return {str(Path(path).relative_to(folder)) for path in paths}


def test_every_file_is_described_and_is_what_was_described(crate, small, folder):
    files = {entity.id: entity for entity in crate.data_entities}
    assert set(files) == below(small.paths, folder) | {"scores.csv"}
    for name, entity in files.items():
        content = (folder / name).read_bytes()
        assert entity["sha256"] == hashlib.sha256(content).hexdigest()
        assert entity["contentSize"] == str(len(content)) and entity["encodingFormat"]


def test_every_file_has_one_action_that_made_it(crate, small, folder):
    made = crate.get_by_type("CreateAction")
    assert {id(one) for one in crate.root_dataset["mentions"]} == {id(one) for one in made}
    results = [file.id for action in made for file in action["result"]]
    assert sorted(results) == sorted(below(small.paths, folder) | {"scores.csv"})
    for action in made:
        (package,) = action["instrument"]
        assert package.type == "SoftwareApplication" and package["softwareVersion"]
        assert action["endTime"] <= crate.datePublished.isoformat()


def test_the_description_has_what_the_format_asks_for(crate):
    root = crate.root_dataset
    for name in ("name", "description", "license", "conformsTo"):
        assert root[name]
    assert crate.metadata["conformsTo"] and crate.metadata["about"].id == "./"
