"""A rectangle of quadrilaterals, straight or arched:  (x, y + 4 r x/L (1 - x/L)),  r the rise.

Boundaries and points (of probes and effects) are named in the straight body's coordinates. Free
displacements are numbered line by line across the body, so that every matrix is a narrow band.
"""

from dataclasses import dataclass, replace

import numpy as np
import skfem

from vibrom.artefacts.hardware import check_memory
from vibrom.bodies.space import PlaneProbe, Space, movable
from vibrom.config.kinds import Cells, Distinct, Edge, Element, Name, Positive
from vibrom.term import SceneError

# Element and the polynomial degree that its quadrature integrates: 2 x 2, 3 x 3 Gauss points.
ELEMENTS = {
    "bilinear": (skfem.ElementQuad1, 3),
    "quadratic": (skfem.ElementQuad2, 5),
    "serendipity": (skfem.ElementQuadS2, 5),
}

FLATTEST = 1e7  # long side over short: its stiffness to bend is 1e-14 of that to stretch


@dataclass(frozen=True)
class Rectangle:
    """A plane body of constant thickness."""

    length: Positive  # m
    height: Positive  # m
    width: Positive  # m, out of plane
    cells: Cells  # along the length, over the height
    element: Element  # bilinear ones lock in shear when they bend
    clamped: Distinct[Edge]  # edges that cannot move
    probes: dict[Name, PlaneProbe]  # displacements that are recorded; tables show the first
    rise: float = 0.0  # m, of an arch: how far its middle lies above its ends

    def build(self) -> Space:
        """Meshed, numbered and watched."""
        (columns, rows), (element, order) = self.cells, ELEMENTS[self.element]
        sides = (self.length / columns, self.height / rows, 4 * abs(self.rise) / columns)
        if max(sides) > FLATTEST * min(sides[:2]):
            raise SceneError(
                f"body: elements of {sides[0]:.3g} x {sides[1]:.3g} m, with a rise of "
                f"{self.rise:.3g} m, are flatter than 1 to {FLATTEST:.0e} and lost in rounding; "
                "choose length, height and rise closer to one another"
            )
        # The matrices of the elements, of which scikit-fem keeps rows, columns and values.
        entries = columns * rows * (2 * element().doflocs.shape[0]) ** 2
        check_memory(3 * 8 * entries, f"a mesh of {columns} x {rows} elements", "lower body.cells")
        straight = skfem.MeshQuad.init_tensor(
            np.linspace(0, self.length, columns + 1), np.linspace(0, self.height, rows + 1)
        ).with_defaults()
        basis = skfem.Basis(straight, skfem.ElementVector(element()), intorder=order)
        named, free = basis.doflocs, movable(basis, self.clamped)
        if self.rise:
            basis = skfem.Basis(self._arched(straight), basis.elem, intorder=order)
        # Reverse Cuthill-McKee leaves the nodes of a line in the order in which it met them: a band
        # up to twice as wide.
        x, y = np.round(named[:, free] / self.length, 9)
        free = free[np.lexsort((y, x) if columns >= rows else (x, y))]
        scalar = basis.with_element(element())
        space = Space(basis, scalar, self.width, tuple(self.clamped), free, named, {})
        return space.watched(self.probes)

    def _arched(self, mesh: skfem.MeshQuad) -> skfem.MeshQuad:
        x, y = mesh.p
        part = x / self.length
        return replace(mesh, doflocs=np.array([x, y + 4 * self.rise * part * (1 - part)]))
