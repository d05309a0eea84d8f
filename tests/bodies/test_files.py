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


def lines_of(*more):
    """The strip of two quadrilaterals, and what follows."""
    text = ["*NODE, NSET=every"] + [f"{k}, {x}, {y}" for k, (x, y, _) in enumerate(STRIP, 1)]
    text += ["*ELEMENT, TYPE=CPS4R, ELSET=Left", "1, 1, 2, 5, 4"]
    return [*text, "*ELEMENT, TYPE=CPS4R", "2, 2, 3, 6, 5", *more]


def test_sets_of_abaqus_have_what_its_own_programs_write(tmp_path):
    """Nodes of blocks and of elements, names in any capitals, surfaces of faces and of nodes."""
    more = ["*NSET, NSET=Of, ELSET=LEFT", "*NSET, NSET=again", "of, 6"]
    more += ["*SURFACE, NAME=side", "left, S4", "2, S2", "*SURFACE, TYPE=NODE, NAME=far", "6, 1."]
    (tmp_path / "strip.inp").write_text("\n".join(lines_of(*more)))
    groups = read(tmp_path / "strip.inp").groups
    found = {name: np.concatenate(parts).tolist() for name, parts in groups.items()}
    assert found.pop("Left") == [[0, 1, 4, 3]] and found.pop("side") == [[3, 0], [2, 5]]
    flat = {name: sorted(sum(members, [])) for name, members in found.items()}
    assert flat == {
        "every": list(range(6)),
        "Of": [0, 1, 3, 4],
        "again": [0, 1, 3, 4, 5],
        "far": [5],
    }


CORNERS = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
CORNERS += [[x, y, 1] for x, y, _ in CORNERS]
FACES = {  # of S1, S2, ...: axis and place of the plane, None: it is aslant
    "C3D8": (range(8), [(2, 0), (2, 1), (1, 0), (0, 1), (1, 1), (0, 0)]),
    "C3D4": ((0, 1, 3, 4), [(2, 0), (1, 0), None, (0, 0)]),
    "C3D6": ((0, 1, 3, 4, 5, 7), [(2, 0), (2, 1), (1, 0), None, (0, 0)]),
}


@pytest.mark.parametrize("kind", FACES)
def test_faces_of_abaqus_are_those_of_its_manual(tmp_path, kind):
    nodes, planes = FACES[kind]
    text = ["*NODE"] + [f"{k}, {x}, {y}, {z}" for k, (x, y, z) in enumerate(CORNERS)]
    text += [f"*ELEMENT, TYPE={kind}, ELSET=body", ", ".join(map(str, [1, *nodes]))]
    for face in range(1, len(planes) + 1):
        text += [f"*SURFACE, NAME=S{face}", f"body, S{face}"]
    (tmp_path / "one.inp").write_text("\n".join(text))
    groups, faces = read(tmp_path / "one.inp").groups, []
    for face, plane in enumerate(planes, 1):
        faces.append(frozenset(groups[f"S{face}"][0][0].tolist()))
        if plane is not None:
            axis, place = plane
            assert faces[-1] == {node for node in nodes if CORNERS[node][axis] == place}
    assert len(set(faces)) == len(planes)


@pytest.mark.parametrize(
    ("more", "says"),
    [
        (["*NSET, NSET=a", "nowhere"], "names a set 'nowhere' that is not there before"),
        (["*NSET, NSET=a", "99"], "names a node 99 that is not there"),
        (["*NSET, NSET=a, ELSET=b"], "names a set 'b' that is not there"),
        (["*NODE", "1, 5., 5."], "two nodes with the number 1"),
        (["*ELEMENT, TYPE=CPS4", "1, 2, 3, 6, 5"], "two elements with the number 1"),
        (["*SURFACE, NAME=a", "left, S5"], r"surface a names no face of its elements \(S1 to S4"),
        (["*SURFACE, NAME=a", "7, S1"], "names an element 7 that is not there"),
        (["*NODE", "7, nan, 0.", "*ELEMENT, TYPE=CPS4", "3, 3, 7, 6, 2"], "place is no number"),
        (["*NODE, SYSTEM=C", "7, 1., 90."], "not in rectangular coordinates"),
        (["*NODE, INPUT=nodes.txt"], "includes another file"),
        (["*ELGEN", "1, 2, 1, 1"], r"has \*ELGEN; export it with all nodes and elements"),
        (["*ELEMENT, TYPE=CPS4", "3, 1, 2, 5"], "elements of 4 nodes have 4 numbers in all"),
        (["*ELEMENT, TYPE=C3D5", "3, 1, 2, 5, 4, 6"], "type C3D5 are not known here"),
        (["*INSTANCE, NAME=a, PART=p", "*INSTANCE, NAME=b, PART=p"], "it has 2 instances"),
    ],
)
def test_what_abaqus_cannot_mean_is_named(tmp_path, more, says):
    (tmp_path / "strip.inp").write_text("\n".join(lines_of(*more)))
    with pytest.raises(SceneError, match=says):
        build(tmp_path / "strip.inp", width=0.1)


def test_lines_and_numbers_of_abaqus_may_be_written_otherwise(tmp_path):
    """A byte order mark, exponents of double numbers, and a keyword that goes on below."""
    text = "\n".join(lines_of()).replace("2, 1, 0", "2, 1.D+00, 0.")
    text = text.replace("TYPE=CPS4R, ELSET", "TYPE=CPS4R,\nELSET")
    (tmp_path / "strip.inp").write_text("\ufeff" + text)
    content = read(tmp_path / "strip.inp")
    np.testing.assert_array_equal(content.points, STRIP)
    assert content.groups["Left"][0].tolist() == [[0, 1, 4, 3]]


def test_an_element_of_two_groups_is_there_once(tmp_path):
    """Gmsh's version 2.2 writes it once for each."""
    path, names = tmp_path / "strip.msh", [(1, 1, "left"), (2, 2, "part"), (2, 3, "near")]
    blocks = [("line", 1, [[1, 4]]), ("quad", 2, QUADS), ("quad", 3, QUADS[:1])]
    write_gmsh(path, blocks, STRIP, names)
    twice = build(path, width=0.1, clamped=["left"])
    write_gmsh(path, blocks[:2], STRIP, names)
    once = build(path, width=0.1, clamped=["left"])
    np.testing.assert_array_equal(twice.element_dofs, once.element_dofs)
    np.testing.assert_array_equal(twice.segments("left"), once.segments("left"))


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
        ("none.msh", None, "cannot be read: No such file"),
        ("many.msh", "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n99999999999999\n", "damaged"),
        ("none.su2", "NDIME= 2\n", "cut off, damaged or of a version"),
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
            "type XYZ9 are not known here; mesh it with triangles",
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
