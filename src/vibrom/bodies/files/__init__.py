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
        if path.exists() and not path.is_file():
            raise Unreadable("it is no file")
        return READERS.get(path.suffix.lower(), foreign.read)(path)
    except Exception as error:  # whatever a reader meets in a file that is not what it seems
        raise SceneError(f"body.mesh = {path} cannot be read: {_why(error)}") from error


def _why(error: Exception) -> str:
    if isinstance(error, Unreadable):
        return str(error)
    if isinstance(error, OSError):
        return error.strerror or str(error)
    if isinstance(error, ImportError):
        return f"that takes the package {error.name}, which is not installed; export .msh or .inp"
    return DAMAGED
