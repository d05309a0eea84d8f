"""A method that asks for the equations of motion is fitted without a recorded motion."""

import pytest
from scenes import THESIS, quadratic_body

from vibrom.artefacts.data import open_dataset
from vibrom.models.rom import rom_from_dataset
from vibrom.steps import fit
from vibrom.steps import structure as structure_step

RECIPE = {
    "scene": "short",
    "method": "equations",
    "kind": "equations",
    "settings": {"order": 5},
    "seed": None,
    "device": "cpu",
}
STOP = {"at": [1.0, 0.01], "direction": "y", "gap": 0.1, "stiffness": 5.0}


@pytest.mark.parametrize("effects", [THESIS, {**THESIS, "stop": STOP}])
def test_it_is_fitted_or_says_why_not(tmp_path, effects):
    scene = {"body": {**quadratic_body(cells=[4, 1]), "shape": "rectangle"}, "effects": effects}
    known, rom = str(tmp_path / "structure.nc"), str(tmp_path / "rom.nc")
    structure_step.run(structure=known, scene=scene, name="short", provenance={})
    fit.run(
        structure=known,
        rom=rom,
        losses=str(tmp_path / "losses.nc"),
        recipe=RECIPE,
        provenance={},
        scene=scene,
    )
    found = open_dataset(rom, "rom")
    if "stop" in effects:
        assert str(found["outcome"].item()) == "skipped"
        assert "effects.stop" in found.attrs["reason"]
    else:
        assert str(found["outcome"].item()) == "ok"
        assert float(found["mapping_seconds"]) > 0.0 == float(found["data_seconds"])
        assert (rom_from_dataset(found).reach > 0.0).all()
