"""The kinds of settings: what a value of the configuration may be.

Every setting is declared once, as a field with one of these kinds, its default and, in the comment
beside it, its unit and meaning. A plug (an effect, a method, ...) needs numerical packages, so the
workflow reads its fields from the text and knows the words of this file, `Literal`, the built-in
types, and the dataclasses of the plug's own file.
"""

from typing import Annotated, Literal

from msgspec import Meta

Positive = Annotated[float, Meta(gt=0)]
NonNegative = Annotated[float, Meta(ge=0)]
Fraction = Annotated[float, Meta(ge=0, le=1)]
Tolerance = Annotated[float, Meta(gt=0, le=0.1)]  # relative
Residual = Annotated[float, Meta(ge=1e-10, le=0.1)]  # relative, of a converged time step
PoissonRatio = Annotated[float, Meta(gt=-1, lt=0.5)]

Count = Annotated[int, Meta(ge=1)]
Whole = Annotated[int, Meta(ge=0)]
Steps = Annotated[int, Meta(ge=20)]  # time steps in one period of the first mode
Seed = Annotated[int, Meta(ge=0, lt=2**32)]

Name = Annotated[str, Meta(pattern="^[A-Za-z0-9][A-Za-z0-9_.-]*$", max_length=60)]
Direction = Literal["x", "y"]
Edge = Literal["left", "right", "bottom", "top"]
Element = Literal["bilinear", "quadratic", "serendipity"]
Point = tuple[float, float]  # m
Cells = tuple[Count, Count]  # along the length, over the height
