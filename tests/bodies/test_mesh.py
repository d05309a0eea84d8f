"""Bodies from mesh files: every kind of element in every format, groups, and what is refused."""

import numpy as np
import pytest
import skfem
from meshes import BLOCKS, NAMES, QUADS, STRIP, build, distorted, strip, write_gmsh
from scenes import LINEAR, UNDAMPED

from vibrom import effects
from vibrom.bodies import space
from vibrom.bodies.files.content import EDGES
from vibrom.bodies.topology import HEXAHEDRON
from vibrom.config.digest import digest
from vibrom.solvers.full.modes import eigenmodes
from vibrom.term import SceneError

# Reference elements: corners, in the order that all formats share.
SQUARE = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
CORNERS = {
    "triangle": [[0, 0, 0], [1, 0, 0], [0, 1, 0]],
    "quad": SQUARE,
    "tetra": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]],
    "hexahedron": [*SQUARE, *([x, y, 1] for x, y, _ in SQUARE)],
    "wedge": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [0, 1, 1]],
}
_TWELVE = [f"{pair:02d}" for pair in (1, 3, 4, 12, 15, 23, 26, 37, 45, 47, 56, 67)]
_RISEN = [f"{pair:02d}" for pair in (1, 12, 23, 30, 45, 56, 67, 74, 4, 15, 26, 37)]
# Where Gmsh's nodes after the corners lie (Gmsh reference manual, "Node ordering").
GMSH = {
    "triangle6": ["01", "12", "20"],
    "quad8": ["01", "12", "23", "30"],
    "quad9": ["01", "12", "23", "30", "0123"],
    "tetra10": ["01", "12", "20", "30", "23", "13"],
    "hexahedron20": _TWELVE,
    "hexahedron27": [*_TWELVE, "0321", "0154", "0473", "1265", "2376", "4567", "01234567"],
}
# And Abaqus's (Keywords reference guide).
ABAQUS = {
    "triangle6": ("CPS6", ["01", "12", "20"]),
    "quad8": ("CPE8R", ["01", "12", "23", "30"]),
    "tetra10": ("C3D10", ["01", "12", "20", "03", "13", "23"]),
    "hexahedron20": (
        "C3D20R",
        ["01", "12", "23", "30", "45", "56", "67", "74", "04", "15", "26", "37"],
    ),
}
FIRST = {"triangle": "CPS3", "quad": "CPE4", "tetra": "C3D4", "hexahedron": "C3D8", "wedge": "C3D6"}


def corner(kind):
    return np.array(CORNERS[kind.rstrip("0123456789")], float)


def bent(points):
    """A map of second degree that moves no corner at x = 0, of a body in the plane or in space."""
    x, y, z = points.T
    return np.stack([x + 0.2 * x * y, y + 0.15 * x * x, z + 0.1 * x * z], axis=1)


def nodes_of(kind, middles):
    corners = corner(kind)
    between = [corners[[int(c) for c in word]].mean(axis=0) for word in middles]
    return bent(np.concatenate([corners, *([between] if between else [])]))


def volume(kind):
    """Of the bent element, by many Gauss points of its own map where it is of second order, by its
    corners where it is not.
    """
    from numpy.polynomial.legendre import leggauss

    x, w = leggauss(8)
    x, w = (x + 1) / 2, w / 2
    p = np.stack(np.meshgrid(x, x, x, indexing="ij"), -1).reshape(-1, 3)
    weight = np.einsum("i,j,k->ijk", w, w, w).ravel()
    name = kind.rstrip("0123456789")
    if name in ("triangle", "quad"):
        p[:, 2] = 0.0
    if name in ("triangle", "tetra", "wedge"):  # collapsed cubes
        weight = weight * (1 - p[:, 0])
        p[:, 1] *= 1 - p[:, 0]
    if name == "tetra":
        left = 1 - p[:, 0] - p[:, 1]
        weight, p[:, 2] = weight * left, p[:, 2] * left
    x, y, _ = p.T
    inplane = (1 + 0.2 * y) * 1.0 - 0.2 * x * 0.3 * x
    depth = 1.0 if name in ("triangle", "quad") else 1 + 0.1 * x
    return float(weight @ (inplane * depth))


def plane(kind):
    return kind.startswith(("triangle", "quad"))


@pytest.mark.parametrize("kind", [*CORNERS, *GMSH])
def test_gmsh_orders_nodes_as_it_says(tmp_path, kind):
    """A curved element has the volume of the map that curved it; one of first order that of its
    corners' own map.
    """
    points, path = nodes_of(kind, GMSH.get(kind, [])), tmp_path / "one.msh"
    write_gmsh(path, [(kind, 1, [range(1, len(points) + 1)])], points)
    made = build(path, width=1.0 if plane(kind) else 0.0)
    found = (made.mass or made.basis).dx.sum()
    if kind in GMSH and kind not in ("quad8", "hexahedron20"):
        assert found == pytest.approx(volume(kind), rel=1e-12)
    elif kind in GMSH:  # serendipity shape functions have this map but for its products
        assert found == pytest.approx(volume(kind), rel=5e-3)
    assert made.size == made.dimension * len(points)


@pytest.mark.parametrize("kind", [*FIRST, *ABAQUS])
def test_abaqus_is_what_gmsh_is(tmp_path, kind):
    name, middles = ABAQUS.get(kind, (FIRST.get(kind), []))
    points = nodes_of(kind, middles)
    rows = [f"{10 * k}, {x:.17g}, {y:.17g}, {z:.17g}" for k, (x, y, z) in enumerate(points, 1)]
    numbers = [str(10 * k) for k in range(1, len(points) + 1)]
    held = ", ".join(numbers[k] for k in np.flatnonzero(points[:, 0] < 1e-9))
    lines = [", ".join(["7", *numbers[:6]]) + ",", ", ".join(numbers[6:])]
    text = ["*Heading", "** made by hand", "*Node", *rows, f"*Element, type={name}, elset=ALL"]
    text += [line for line in lines if line] + ["*Nset, nset=held", held]
    (tmp_path / "one.inp").write_text("\n".join(text))
    points = nodes_of(kind, GMSH.get(kind, []))
    write_gmsh(tmp_path / "one.msh", [(kind, 1, [range(1, len(points) + 1)])], points)
    width = {"width": 1.0 if plane(kind) else 0.0}
    ours = build(tmp_path / "one.inp", clamped=["held"], **width)
    loose = build(tmp_path / "one.msh", **width)
    assert ours.basis.dx.sum() == pytest.approx(loose.basis.dx.sum(), rel=1e-12)
    assert np.abs(loose.named[0, loose.free]).min() < 1e-9 < ours.named[0, ours.free].min()


@pytest.mark.parametrize("kind", ["triangle6", "tetra10", "hexahedron27"])
def test_other_files_are_read_by_meshio(tmp_path, kind):
    import meshio

    points = nodes_of(kind, GMSH[kind])
    write_gmsh(tmp_path / "one.msh", [(kind, 1, [range(1, len(points) + 1)])], points)
    meshio.read(tmp_path / "one.msh").write(tmp_path / "one.vtu")
    made = build(tmp_path / "one.vtu", width=1.0 if plane(kind) else 0.0)
    assert (made.mass or made.basis).dx.sum() == pytest.approx(volume(kind), rel=1e-12)
    (tmp_path / "one.vtu").write_text("<nothing>")
    with pytest.raises(SceneError, match="one.vtu cannot be read"):
        build(tmp_path / "one.vtu")


def test_the_file_in_the_repository_is_what_its_script_makes(tmp_path):
    import runpy
    import shutil
    from pathlib import Path

    script = Path("config/scenes/perforated_beam.py")
    shutil.copy(script, tmp_path)
    runpy.run_path(str(tmp_path / script.name), run_name="__main__")
    assert (tmp_path / "perforated_beam.msh").read_text() == script.with_suffix(".msh").read_text()


def test_groups_of_version_4_are_boundaries_and_points():
    probes = {"end": {"at": "tip", "direction": "y"}}
    made = build("config/scenes/perforated_beam.msh", width=0.05, clamped=["fixed"], probes=probes)
    assert made.dof_location[made.probes["end"]] == pytest.approx([1.0, 0.02])
    # Sides of second order follow the hole: its area to the fourth order of their angle, pi/4.
    assert made.basis.dx.sum() == pytest.approx(0.04 - np.pi * 0.012**2, rel=1e-4)
    around = made.segments("hole")
    assert np.linalg.norm(made.basis.doflocs[:, around[:, :, 0]].T - [0.25, 0.02], axis=-1) == (
        pytest.approx(0.012)
    )
    term = effects.assemble(made, {**UNDAMPED, "follower_load": {"edge": "hole", "pressure": 1.0}})
    assert np.isfinite(term.dead_load).all()


def test_a_raised_order_is_that_of_the_quadratic_rectangle(tmp_path):
    probes = {"tip": {"at": [2.0, 1.0], "direction": "y"}}
    size = {"length": 2.0, "height": 1.0, "width": 0.1, "cells": [2, 1], "clamped": ["left"]}
    ours = strip(tmp_path, order=2, probes=probes)
    other = space.build({**size, "element": "quadratic", "probes": probes})
    mine, theirs = (eigenmodes(effects.assemble(each, LINEAR), 3) for each in (ours, other))
    np.testing.assert_allclose(mine.frequency, theirs.frequency, rtol=1e-9)
    assert mine.shape[0][ours.probes["tip"]] == pytest.approx(
        theirs.shape[0][other.probes["tip"]], rel=1e-9
    )


def test_what_is_no_mesh_of_one_body_is_one_line(tmp_path):
    away = [*STRIP, [5, 0, 0], [6, 0, 0], [6, 1, 0], [5, 1, 0]]
    tilted = [*STRIP[:5], [2, 1, 0.3]]
    thin = [[x, 1e-9 * y, z] for x, y, z in STRIP]
    hinged = [*QUADS, [6, 8, 9, 10]]
    crossed = [[1, 2, 5, 4], [2, 3, 5, 6]]
    cases = [
        ({"clamped": ["rihgt"]}, r"body.clamped\[0\] = 'rihgt' is no group of .*choose from"),
        ({"clamped": ["lfet"]}, "did you mean 'left'"),
        ({"clamped": ["end"]}, "is a point about which the body turns freely; clamp more"),
        (
            {"probes": {"a": {"at": "enb", "direction": "y"}}},
            "a.at = 'enb' is no group of",
        ),
        ({"probes": {"a": {"at": "left", "direction": "y"}}}, "is a group of 2 nodes; name one of"),
        ({"probes": {"a": {"at": [2.0, 1.0], "direction": "z"}}}, "along 'z' is not in the body"),
        ({"width": 0.0}, "body.width is missing; a plane body needs one"),
        ({"digest": "0"}, "has changed since this run began; run it again"),
        ({"blocks": [("quad", 2, hinged)], "points": away}, "is 2 parts that share no side"),
        ({"blocks": [("quad", 2, [*QUADS, [3, 6, 6, 2]])]}, "twice in 1 of its 3 elements"),
        (
            {"blocks": [("quad", 2, crossed)]},
            "1 elements are turned inside out, the first",
        ),
        ({"points": thin}, "2 elements are flat, the first one near"),
        (
            {"blocks": [("quad", 2, [*QUADS, [7, 8, 9, 10]])], "points": away},
            "is 2 parts that share",
        ),
        ({"points": tilted}, "is a surface in space, 0.3 m deep along z"),
        (
            {"blocks": [("quad", 2, QUADS[:1]), ("triangle", 2, [[2, 3, 5]])]},
            "mixes quadrilaterals ",
        ),
        ({"blocks": [("line", 1, [[1, 4]])]}, "has no elements of a plane or solid body"),
        (
            {"blocks": [("line", 1, [[1, 4], [1, 5]]), *BLOCKS[1:]]},
            "1 of the 2 facets of group 'left' belong to",
        ),
        ({"blocks": [("quad", 2, [[1, 2, 5, 40]])]}, "is cut off, damaged or of a version"),
    ]
    for changes, says in cases:
        with pytest.raises(SceneError, match=says) as refused:
            strip(tmp_path, **changes)
        assert "\n" not in str(refused.value)


def test_nodes_without_an_element_are_left_out(tmp_path):
    made = strip(tmp_path, points=[*STRIP, [9, 9, 0]])
    assert made.size == 8


def folded():
    """A quadrilateral whose lower side bulges beyond its middle."""
    points = [*SQUARE, [0.5, 0.9, 0], [1, 0.5, 0], [0.5, 1, 0], [0, 0.5, 0], [0.5, 0.5, 0]]
    return [("quad9", 2, [range(1, 10)])], points


def test_elements_may_be_turned_inside_out_between_their_corners(tmp_path):
    write_gmsh(tmp_path / "one.msh", *folded())
    with pytest.raises(SceneError, match="1 elements are turned inside out"):
        build(tmp_path / "one.msh", width=0.1)


def in_space(tmp_path, blocks, **changes):
    """Eight hexahedra, numbered anyhow, of a group of their own, and further blocks of corners."""
    mesh = skfem.MeshHex.init_tensor(*[np.linspace(0.0, 1.0, 3)] * 3)
    shuffled = np.random.default_rng(0).permutation(mesh.nvertices)
    points = np.empty((mesh.nvertices, 3))
    points[shuffled] = mesh.p.T
    order = np.argsort(HEXAHEDRON)
    cells = ("hexahedron", 1, 1 + shuffled[mesh.t[order]].T)
    found = [
        (kind, tag, [[1 + int(np.linalg.norm(points - at, axis=1).argmin()) for at in corners]])
        for kind, tag, corners in blocks
    ]
    write_gmsh(tmp_path / "one.msh", [cells, *found], points, [(3, 1, "part")])
    return build(tmp_path / "one.msh", **changes)


@pytest.mark.parametrize("order", [1, 2])
def test_edges_of_a_body_in_space_are_held_with_their_middles(tmp_path, order):
    """Two of its edges that are no parallels hold it, and a single one lets it turn."""
    edges = [("line", 2, [[0, 0, 0], [0.5, 0, 0]]), ("line", 3, [[0, 0, 1], [0, 0.5, 1]])]
    made = in_space(tmp_path, edges, clamped=["2", "3"], order=order)
    assert set(made.basis.mesh.boundaries) == set()
    assert made.basis.N - made.size == 3 * 2 * (1 + order)
    with pytest.raises(SceneError, match="is a line about which the body turns freely"):
        in_space(tmp_path, edges, clamped=["2"], order=order)


def test_a_digest_is_of_what_the_file_holds(tmp_path):
    write_gmsh(tmp_path / "strip.msh", BLOCKS, STRIP, NAMES)
    before = digest(tmp_path / "strip.msh")
    strip(tmp_path, digest=before)
    write_gmsh(tmp_path / "strip.msh", BLOCKS, [*STRIP[:5], [2.1, 1, 0]], NAMES)
    with pytest.raises(SceneError, match="has changed"):
        build(tmp_path / "strip.msh", width=0.1, clamped=["left"], digest=before)


def test_edges_of_all_kinds_have_a_middle():
    """The order in which files give them is that of the tables above, up to Gmsh's own."""
    for kind, (_, middles) in ABAQUS.items():
        assert ["".join(map(str, pair)) for pair in EDGES[kind]] == middles


@pytest.mark.parametrize("kind", ["quad8", "hexahedron20"])
def test_middles_that_a_file_lacks_lie_where_its_shape_functions_have_them(kind):
    made = distorted(kind)
    mesh, own = made.basis.mesh, made.scalar.elem
    local = mesh.doflocs[:, mesh.dofs.element_dofs]
    count = own.doflocs.shape[0]
    at = type(mesh).elem().doflocs[count:].T
    shapes = np.array([own.lbasis(at, a)[0] for a in range(count)])
    expected = np.einsum("iae,ap->ipe", local[:, :count], shapes)
    np.testing.assert_allclose(local[:, count:], expected, atol=1e-14)
