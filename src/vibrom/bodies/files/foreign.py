"""Gmsh's files, and any other but Abaqus's, by meshio."""

import contextlib
import io
from collections.abc import Iterator
from pathlib import Path

import meshio
import numpy as np

from vibrom.bodies.files.content import SHAPES, Content, Unreadable, foreign_to

PHYSICAL = "gmsh:physical"  # meshio's name of an element's physical group, 0 without one


def read(path: Path) -> Content:
    """See `files.read`."""
    path.stat()
    found = _found(path)
    points = np.zeros((len(found.points), 3))
    points[:, : found.points.shape[1]] = found.points
    content = Content(points)
    for place, block in enumerate(found.cells):
        if block.type not in SHAPES:
            raise Unreadable(foreign_to(block.type))
        nodes = np.asarray(block.data, dtype=np.int64)
        if (nodes < 0).any():
            raise Unreadable("its elements name nodes that are not there; export it again")
        content.elements.setdefault(block.type, []).append(nodes)
        corners = nodes[:, : SHAPES[block.type][1]]
        for name, members in _groups(found, place, SHAPES[block.type][0]):
            content.groups.setdefault(name, []).append(corners[members])
    for name, members in found.point_sets.items():
        content.groups.setdefault(name, []).append(np.asarray(members, int)[:, None])
    return content


def _found(path: Path) -> meshio.Mesh:
    said = io.StringIO()
    try:
        with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
            return meshio.read(path)
    except (meshio.ReadError, SystemExit) as error:  # it ends the program where it gives up
        why = " ".join(said.getvalue().split()) or str(error)
        raise Unreadable(f"meshio says {why!r}; export .msh (4.1 or 2.2) or .inp") from error
    except ValueError as error:
        if PHYSICAL in str(error):  # of version 4.1, it reads either all elements' groups or none
            raise Unreadable(
                "some of its elements are in no physical group; export those of groups only "
                "(Mesh.SaveAll = 0)"
            ) from error
        raise


def _groups(found: meshio.Mesh, place: int, dim: int) -> Iterator[tuple[str, np.ndarray]]:
    """Names, or numbers, of a block's groups, and which of its elements are in them."""
    named = set()
    for name, blocks in found.cell_sets.items():
        if name.startswith("gmsh:") or blocks[place] is None or not len(blocks[place]):
            continue
        named.add(name)
        yield name, np.asarray(blocks[place], int)
    names = {(number, of): name for name, (number, of) in found.field_data.items()}
    numbers = np.abs(found.cell_data[PHYSICAL][place]) if PHYSICAL in found.cell_data else []
    for number in np.unique(numbers):
        name = names.get((number, dim), str(number))
        if number and name not in named:
            yield name, np.flatnonzero(numbers == number)
