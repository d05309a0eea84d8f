"""The kinds of settings: what a value of the configuration may be.

Every setting is declared once, as a field with one of these kinds, its default and, in the comment
beside it, its unit and meaning. A plug (an effect, a method, ...) needs numerical packages, so the
workflow reads its fields from the text and knows the words of this file, `Literal`, the built-in
types, and the dataclasses of the plug's own file.
"""

from typing import Annotated, Any, Literal, TypeVar

from msgspec import Meta

Item = TypeVar("Item")
Distinct = Annotated[list[Item], Meta(extra_json_schema={"uniqueItems": True})]
Several = Annotated[Distinct[Item], Meta(min_length=1)]

Positive = Annotated[float, Meta(gt=0)]
NonNegative = Annotated[float, Meta(ge=0)]
Fraction = Annotated[float, Meta(ge=0, le=1)]
Ratio = Annotated[float, Meta(ge=0, lt=1)]
Tolerance = Annotated[float, Meta(gt=0, le=0.1)]  # relative
Turn = Annotated[float, Meta(gt=0, le=1)]  # rad
PoissonRatio = Annotated[float, Meta(gt=-1, lt=0.5)]

Count = Annotated[int, Meta(ge=1, le=1_000_000)]
Whole = Annotated[int, Meta(ge=0, le=1_000_000)]
Step = Annotated[int, Meta(ge=1, le=10_000_000)]  # the number of a time step
Steps = Annotated[int, Meta(ge=20, le=1_000_000)]  # time steps in one period of the first mode
Units = Annotated[int, Meta(ge=1, le=10_000)]  # of a layer: its weights are the square of that
Order = Annotated[int, Meta(ge=1, le=100)]  # of a polynomial
Seed = Annotated[int, Meta(ge=0, lt=2**32)]

Group = Annotated[str, Meta(min_length=1, max_length=60)]  # named in a mesh
Coordinates = Annotated[list[float], Meta(min_length=2, max_length=3)]  # m
MeshFile = Annotated[str, Meta(min_length=1)]  # a path, from the folder of the scene's file on
ElementOrder = Annotated[int, Meta(ge=1, le=2)]
Point = Group | Coordinates  # m, or the name of a group of one node
PlanePoint = tuple[float, float]  # m
PlaneDirection = Literal["x", "y"]
Lines = Annotated[int, Meta(ge=1, le=100_000)]  # of elements
Cells = tuple[Lines, Lines]  # along the length, over the height
Direction = Literal["x", "y", "z"]
Edge = Literal["left", "right", "bottom", "top"]
Face = Literal["left", "right", "bottom", "top", "back", "front"]
# Name of a file of src/vibrom/signals -> its settings.
Signal = Annotated[dict[str, dict[str, Any]], Meta(min_length=1, extra={"settings": "signals"})]
DataFile = Annotated[str, Meta(min_length=1)]  # a path, from the folder of the scene's file on
Element = Literal["bilinear", "quadratic", "serendipity"]
SolidElement = Literal["trilinear", "quadratic", "serendipity"]

NAME = r"^[A-Za-z0-9][A-Za-z0-9_.-]*\Z"
DEVICE = r"^(auto|cpu|cuda(:[0-9]+)?)\Z"
FOLDER = r"^[^{}<>*?\x00-\x1f]+\Z"
ROM_CLASS = r"^vibrom[.][a-z0-9_.]+:[A-Za-z0-9]+\Z"
# Pattern -> what it asks for, in words.
FORMS = {
    NAME: "of letters, digits, '_', '-' and '.', and begin with a letter or digit",
    DEVICE: "auto, cpu, cuda or cuda:<number>",
    FOLDER: "a path without { } < > * and ?",
    ROM_CLASS: "module:name of a class of vibrom",
}
# A file of this folder of vibrom.
Stepper = Annotated[str, Meta(extra={"plugs": "solvers/reduced/steppers"})]
TimeScheme = Annotated[str, Meta(extra={"plugs": "solvers/full/schemes"})]
Name = Annotated[str, Meta(pattern=NAME, max_length=60)]  # of a scene, probe, method or guard
Device = Annotated[str, Meta(pattern=DEVICE)]
Folder = Annotated[str, Meta(pattern=FOLDER)]
RomClass = Annotated[str, Meta(pattern=ROM_CLASS)]
