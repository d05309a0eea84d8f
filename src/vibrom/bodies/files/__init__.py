"""Mesh files: Gmsh's (.msh) and whatever else meshio reads, and Abaqus's (.inp).

Own code for the last: of Abaqus's elements meshio knows no CPE3, CPE4, CPE8, CPS6 or CPS8, and of
several *NODE blocks it keeps the last.
"""

from pathlib import Path

from vibrom.bodies.files import abaqus, foreign
from vibrom.bodies.files.content import Content, Unreadable
from vibrom.term import SceneError

DAMAGED = "it is cut off, damaged or of a version that is not known"
READERS = {".inp": abaqus.read}


def read(path: Path) -> Content:
    """Nodes, elements and named groups; raises SceneError of one line."""
    try:
        return READERS.get(path.suffix, foreign.read)(path)
    except OSError as error:
        raise SceneError(f"body.mesh = {path} cannot be read ({error.strerror})") from error
    except (Unreadable, ValueError, IndexError, KeyError) as error:
        why = str(error) if isinstance(error, Unreadable) else DAMAGED
        raise SceneError(f"body.mesh = {path} cannot be read: {why}") from error
