"""An artefact of another, a damaged one, or one made with other settings is not used without a
word.
"""

import json
import os
import subprocess
import sys

import netCDF4
import numpy as np
import pytest
import xarray as xr

from vibrom.artefacts import identity
from vibrom.artefacts.data import label, open_dataset, save_dataset, scored, variable
from vibrom.artefacts.files import DataError
from vibrom.models.rom import rom_from_dataset

PROVENANCE = {"source_digest": "0123456789abcdef", "versions": '{"numpy": "2.0"}'}
ASKED = {"recipe": {"epochs": 400, "hidden": [64, 32]}, "name": "folding", "provenance": {}}


def release(value=1.0, **names):
    dataset = xr.Dataset(
        {"displacement": variable(("role", "dof"), np.full((2, 300), value), "m", "displacement")}
    )
    return label(dataset, "release", **{"scene": "small", "method": "full_order", **names})


@pytest.fixture
def place(tmp_path):
    folder = tmp_path / "results/small/full_order"
    folder.mkdir(parents=True)
    return folder / "release.nc"


@pytest.mark.parametrize(
    "names, says",
    [
        ({"scene": "large"}, "scene is 'large', but 'small' belongs here"),
        ({"method": "split"}, "method is 'split', but 'full_order' belongs here"),
        ({"seed": 3}, "seed is 3, but -1 belongs here"),
    ],
)
def test_the_artefact_of_another_is_refused(place, names, says):
    save_dataset(release(**names), place)
    with pytest.raises(DataError, match=f"release.nc: {says}; delete it and run again"):
        open_dataset(place, "release")


def test_where_a_file_lies_says_whose_it_must_be():
    of_model = {"scene": "a", "method": "split", "seed": 2, "kind": "decay"}
    assert identity.place("x/a/split/seed_2/decay.nc") == of_model
    assert identity.place("a/split/unseeded/rom.nc")["seed"] == identity.FITTED_ONCE
    assert identity.place("/x/a/full_order/train.nc")["role"] == "train"
    assert identity.place("somewhere/else/train.nc") == {}


@pytest.mark.parametrize("count", [1, 40])
def test_doubles_that_were_changed_in_the_file_are_noticed(place, count):
    save_dataset(release(), place)
    open_dataset(place, "release")
    raw = bytearray(place.read_bytes())
    first = raw.find(np.full(8, 1.0).tobytes())
    for index in range(count):
        raw[first + 8 * index + 3] ^= 1  # one bit of the fraction, about 1e-9 of the value
    place.write_bytes(raw)
    with pytest.raises(DataError, match="damaged, as its content is not what was written"):
        open_dataset(place, "release")


def test_an_attribute_that_was_changed_is_noticed(place):
    save_dataset(release(reason=""), place)
    with netCDF4.Dataset(place, "a") as file:
        file.reason = "another"
    with pytest.raises(DataError, match="damaged"):
        open_dataset(place, "release")


def test_what_comes_back_from_a_file_has_the_content_that_was_written(tmp_path):
    """Of every type that artefacts hold: text, whole numbers, truth values, nothing at all."""
    arrays = {
        "displacement": variable("role", np.array([np.nan, np.inf]), "m", "numbers"),
        "words": variable("word", np.array(["a", "Ω"], dtype=object), "1", "text"),
        "none": variable("nothing", np.array([], dtype=object), "1", "no text"),
        "counts": variable("word", np.array([1, 2], dtype=np.int32), "1", "whole numbers"),
        "flags": variable("word", np.array([True, False]), "1", "truth values"),
        "outcome": variable((), "ok", "1", "one word"),
    }
    attributes = {"reason": "", "several": [1, 2], "one": [3], "number": 0.1, "text": "Ω"}
    dataset = label(xr.Dataset(arrays), "release", scene="a", method="b").assign_attrs(attributes)
    for made in (dataset, scored(dataset, {}, {}), scored(dataset, {"x": 1.0}, {"x": "1"})):
        save_dataset(made, tmp_path / "a.nc")
        again = open_dataset(tmp_path / "a.nc", "release")
        assert again.attrs["content"] == identity.content(made)


@pytest.fixture
def made(place):
    """An artefact with all that it says of how it was made, and what it was made from."""
    structure = place.with_name("structure.nc")
    xr.Dataset(attrs={"content": "1111"}).to_netcdf(structure)
    inputs = {"structure": str(structure)}
    told = {"asked": identity.asked(ASKED), "made_from": identity.made_from(inputs)}
    save_dataset(release(), place, PROVENANCE | told)
    return lambda asked=ASKED, provenance=PROVENANCE, inputs=inputs: identity.stale(
        place, asked, provenance, inputs
    )


def test_what_was_asked_is_compared_with_what_is_asked(made):
    assert made() is None
    assert made(inputs={}) is None  # yet to be made
    carried = PROVENANCE | {"versions": json.dumps({"numpy": "2.0"})}
    assert made(provenance=carried) is None
    other = {**ASKED, "recipe": {"epochs": 200, "hidden": [64, 32]}}
    assert made(other) == "made with other settings (recipe.epochs = 400, now 200)"
    assert "name = 'folding', now None" in made({"recipe": ASKED["recipe"]})
    assert made(provenance=PROVENANCE | {"source_digest": "f"}).startswith("made by other code")
    newer = PROVENANCE | {"versions": '{"numpy": "3.0"}'}
    assert made(provenance=newer) == "made with other packages (numpy = '2.0', now '3.0')"


def test_another_input_makes_it_stale(made, place):
    xr.Dataset(attrs={"content": "2222"}).to_netcdf(place.with_name("structure.nc"), mode="w")
    assert made() == "made from other data (structure = '1111', now '2222')"


def test_another_file_of_the_same_moment_is_another_input(tmp_path):
    """As copies that keep their times are."""
    mine, other = tmp_path / "mine.msh", tmp_path / "other.msh"
    mine.write_text("one")
    other.write_text("two")
    os.utime(other, ns=(mine.stat().st_atime_ns, mine.stat().st_mtime_ns))
    before = identity.made_from({"mesh": str(mine)})
    other.replace(mine)
    assert identity.made_from({"mesh": str(mine)}) != before


def test_a_damaged_file_is_stale_too(made, place):
    place.write_bytes(place.read_bytes()[:500])
    assert made() == "not a readable netCDF file"


def test_a_file_that_another_program_holds_open_is_read(place):
    """In a process of its own: HDF5 decides once whether it locks files."""
    save_dataset(release(), place)
    code = "from vibrom.artefacts.data import open_dataset; open_dataset({!r}, 'release')"
    with netCDF4.Dataset(place, "a"):
        subprocess.run([sys.executable, "-c", code.format(str(place))], check=True)


@pytest.mark.parametrize(
    "named",
    [
        "antigravity:fly",
        "os:system",
        "vibrom.methods.split:Split",
        "vibrom.latent.polynomial_rom:np",
        "",
    ],
)
def test_the_model_of_a_stranger_runs_no_code_but_that_of_known_classes(named):
    stranger = xr.Dataset(attrs={"rom": named})
    with pytest.raises(DataError, match="names no model class of vibrom"):
        rom_from_dataset(stranger)
    assert "antigravity" not in sys.modules


@pytest.mark.parametrize(
    "made_by, read",
    [("0.1.0", False), ("0.2.0.dev0", True), ("0.10.3", True), ("1.0", True), (None, True)],
)
def test_artefacts_of_versions_that_stored_other_things_are_refused(place, made_by, read):
    versions = {} if made_by is None else {"vibrom": made_by}
    save_dataset(release(), place, {"versions": json.dumps(versions)})
    if read:
        open_dataset(place, "release")
    else:
        with pytest.raises(DataError, match="made by vibrom 0.1.0, .* from version 0.2 on"):
            open_dataset(place, "release")


def test_damage_to_what_says_the_version_is_damage(place):
    save_dataset(release(), place, PROVENANCE)
    with netCDF4.Dataset(place, "a") as file:
        file.versions = file.versions[:-1]  # no JSON any more
    with pytest.raises(DataError, match="damaged, as its content is not what was written"):
        open_dataset(place, "release")
