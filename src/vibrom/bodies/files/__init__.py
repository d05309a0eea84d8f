"""Mesh files: Gmsh's text (.msh, 2.2 and 4.1), Abaqus (.inp), and whatever else meshio reads.

Own code for the first two, of which meshio loses the names of Gmsh's groups in version 2.2 and
knows no Abaqus elements CPE4, CPS6 or CPE8.
"""

from pathlib import Path

from vibrom.bodies.files import abaqus, foreign, gmsh
from vibrom.bodies.files.content import Content, Unreadable
from vibrom.term import SceneError

READERS = {".msh": gmsh.read, ".inp": abaqus.read}


def read(path: Path) -> Content:
    """Nodes, elements and named groups; raises SceneError of one line."""
    try:
        return READERS.get(path.suffix, foreign.read)(path)
    except OSError as error:
        raise SceneError(f"body.mesh = {path} cannot be read ({error.strerror})") from error
    except (Unreadable, ValueError, IndexError, KeyError, StopIteration) as error:
        why = str(error) if isinstance(error, Unreadable) else "it is cut off or damaged"
        raise SceneError(f"body.mesh = {path} cannot be read: {why}") from error
