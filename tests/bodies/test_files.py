"""Mesh files: their groups and sets, and what cannot be read."""

import numpy as np
import pytest
from meshes import QUADS, STRIP, build, write_gmsh

from vibrom.bodies.files import read
from vibrom.term import SceneError


def test_groups_without_a_name_have_their_number(tmp_path):
    path = tmp_path / "strip.msh"
    for number in (7, -7):  # of a group whose elements are turned
        write_gmsh(path, [("line", number, [[1, 4]]), ("quad", 0, QUADS)], STRIP)
        made = build(path, width=0.1, clamped=["7"])
        assert made.size == 8 and set(made.basis.mesh.boundaries) == {"7"}


def test_binary_files_have_the_groups_of_text(tmp_path):
    import meshio

    text = "config/scenes/perforated_beam.msh"
    meshio.read(text).write(tmp_path / "one.msh", file_format="gmsh22", binary=True)
    probes = {"end": {"at": "tip", "direction": "y"}}
    found, true = (
        build(path, width=0.05, clamped=["fixed"], probes=probes)
        for path in (tmp_path / "one.msh", text)
    )
    assert found.probes == true.probes and found.size == true.size
    np.testing.assert_array_equal(found.segments("hole"), true.segments("hole"))


def test_sets_of_abaqus_are_ranges_names_and_lists(tmp_path):
    text = ["*NODE"] + [f"{k}, {x}, {y}" for k, (x, y, _) in enumerate(STRIP, 1)]
    text += ["*ELEMENT, TYPE=CPE4", "1, 1, 2, 5, 4", "2, 2, 3, 6, 5"]
    text += ["*ELEMENT, TYPE=B21, ELSET=edge", "3, 1, 4"]
    text += ["*NSET, NSET=low, GENERATE", "1, 3, 1", "*NSET, NSET=end", "6"]
    text += ["*NSET, NSET=both", "low, end"]
    (tmp_path / "strip.inp").write_text("\n".join(text))
    groups = read(tmp_path / "strip.inp").groups
    found = {name: np.concatenate(parts).ravel().tolist() for name, parts in groups.items()}
    assert found == {"edge": [0, 3], "low": [0, 1, 2], "end": [5], "both": [0, 1, 2, 5]}


# Version 4.1: a line in a group, a triangle in none.
PARTLY = """$MeshFormat
4.1 0 8
$EndMeshFormat
$Entities
0 1 1 0
1 0 0 0 0 1 0 1 1 0
1 0 0 0 1 1 0 0 0
$EndEntities
$Nodes
1 3 1 5
2 1 0 3
1
2
5
0 0 0
1 0 0
0 1 0
$EndNodes
$Elements
2 2 1 2
1 1 1 1
1 1 5
2 1 2 1
2 1 2 4
$EndElements
"""


@pytest.mark.parametrize(
    "name, text, says",
    [
        ("none.msh", None, "cannot be read .No such file"),
        ("bad.msh", "nonsense", "meshio says .*Couldn't read file"),
        ("old.msh", "$MeshFormat\n1 0 8\n$EndMeshFormat\n", "of a version that is not known"),
        ("some.msh", PARTLY, "some of its elements are in no physical group"),
        ("hole.msh", PARTLY.replace("1 0 1 1 0", "1 0 0 0"), "name nodes that are not there"),
        (
            "torn.msh",
            "$MeshFormat\n2.2 0 8\n$Nodes\n1\n1 0\n$Elements\n1\nx\n",
            "cut off, damaged or of a version",
        ),
        ("two.inp", "*PART\n*PART\n*NODE\n1,0,0\n", "it has 2 parts; export the one"),
        (
            "shell.inp",
            "*NODE\n1,0,0\n*ELEMENT, TYPE=XYZ9\n",
            "type XYZ9 are none of a plane",
        ),
        ("empty.inp", "*HEADING\n", "it has no .NODE or no .ELEMENT"),
    ],
)
def test_a_file_that_cannot_be_read_is_one_line(tmp_path, name, text, says):
    if text is not None:
        (tmp_path / name).write_text(text)
    with pytest.raises(SceneError, match=says) as refused:
        build(tmp_path / name)
    assert "\n" not in str(refused.value)
