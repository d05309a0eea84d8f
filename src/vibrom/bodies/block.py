"""A block of hexahedra: length along x, height along y, width along z.

Its faces are left and right (x), bottom and top (y), back and front (z, from low to high).
"""

from dataclasses import dataclass

import numpy as np
import skfem

from vibrom.artefacts.hardware import check_memory
from vibrom.bodies.elements import bases
from vibrom.bodies.space import Probe, Space, movable, numbered
from vibrom.config.kinds import Distinct, Face, Lines, Name, Positive, SolidElement

KINDS = {"trilinear": "hexahedron", "quadratic": "hexahedron27", "serendipity": "hexahedron20"}
SIDES = ("left", "right", "bottom", "top", "back", "front")


@dataclass(frozen=True)
class Block:
    """A body in space."""

    length: Positive  # m
    height: Positive  # m
    width: Positive  # m
    cells: tuple[Lines, Lines, Lines]  # along the length, over the height, over the width
    element: SolidElement  # trilinear ones lock in shear when they bend
    clamped: Distinct[Face]  # faces that cannot move
    probes: dict[Name, Probe]  # displacements that are recorded; tables show the first

    def build(self) -> Space:
        """Meshed, numbered and watched."""
        size, kind = (self.length, self.height, self.width), KINDS[self.element]
        shapes = {"hexahedron": 8, "hexahedron20": 20, "hexahedron27": 27}[kind]
        entries = float(np.prod(self.cells)) * (3 * shapes) ** 2
        what = f"a mesh of {' x '.join(map(str, self.cells))} elements"
        check_memory(3 * 8 * entries, what, "lower body.cells")
        lines = [np.linspace(0.0, side, count + 1) for side, count in zip(size, self.cells)]
        mesh = skfem.MeshHex.init_tensor(*lines)
        middle = mesh.p[:, mesh.facets].mean(axis=1)
        ends = [(axis, end) for axis in range(3) for end in (0.0, size[axis])]
        mesh = mesh.with_boundaries(
            {
                name: np.flatnonzero(np.abs(middle[axis] - end) < 1e-9 * size[axis])
                for name, (axis, end) in zip(SIDES, ends)
            }
        )
        basis, scalar, mass = bases(mesh, kind)
        free = numbered(scalar, basis, movable(basis, self.clamped))
        space = Space(basis, scalar, 1.0, tuple(self.clamped), free, basis.doflocs, {}, mass)
        return space.watched(self.probes)
