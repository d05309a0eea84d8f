"""Mesh files: Gmsh's text (.msh, 2.2 and 4.1), Abaqus (.inp), and what meshio reads where that
package is installed.
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
