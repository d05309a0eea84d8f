"""Any other mesh file, by meshio."""

import contextlib
import io
from pathlib import Path

import meshio
import numpy as np

from vibrom.bodies.files.content import SHAPES, Content, Unreadable


def read(path: Path) -> Content:
    """See `files.read`."""
    path.stat()
    said = io.StringIO()
    try:
        with contextlib.redirect_stdout(said):
            found = meshio.read(path)
    except (meshio.ReadError, SystemExit) as error:  # it ends the program where it gives up
        why = " ".join(said.getvalue().split()) or str(error)
        raise Unreadable(f"meshio says {why!r}; export .msh or .inp") from error
    points = np.zeros((len(found.points), 3))
    points[:, : found.points.shape[1]] = found.points
    content = Content(points)
    for number, block in enumerate(found.cells):
        if block.type not in SHAPES:
            raise Unreadable(f"its elements of type {block.type} are not known")
        nodes = np.asarray(block.data, dtype=np.int64)
        content.add(block.type, nodes, [])
        for name, members in found.cell_sets.items():
            if members[number] is not None and len(members[number]):
                corners = nodes[np.asarray(members[number], int), : SHAPES[block.type][1]]
                content.groups.setdefault(name, []).append(corners)
    for name, members in found.point_sets.items():
        content.groups.setdefault(name, []).append(np.asarray(members, int)[:, None])
    return content
