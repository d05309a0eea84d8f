"""A couple on an edge, or on a face of a body in space: 1 N m per unit of the signal about an axis.

    p_a = int N_a t dA,    t = e x (X - c)/I,    I = int |e x (X - c)|^2 dA

with the axis e and the edge's middle c: forces that turn it as a rigid edge would, without a
resultant. Their directions stay fixed when the body turns: an edge that has turned by an angle
about the axis feels the cosine of it.
"""

from dataclasses import dataclass

import numpy as np
import skfem

from vibrom.bodies.space import AXES, Space
from vibrom.config.kinds import Direction, Group
from vibrom.effects import Load
from vibrom.term import SceneError, Term

STAGE = "load"


@dataclass(frozen=True)
class Couple(Load):
    edge: Group  # of a plane body, or a face of one in space
    about: Direction = "z"  # of a plane body z

    def assemble(self, space: Space, base: Term) -> Term:
        facets = space.boundary("effects.couple.edge", self.edge)
        if space.dimension == 2 and self.about != "z":
            raise SceneError(
                f"effects.couple.about = {self.about!r} would turn a plane body out of its plane; "
                "leave it out"
            )
        if space.scalar.elem.refdom.brefdom is None:
            raise SceneError("effects.couple acts on no wedges; mesh the body without them")
        edge = skfem.FacetBasis(space.basis.mesh, space.basis.elem, facets=facets, intorder=5)
        area = space.thickness * edge.dx
        at = np.zeros((3, *area.shape))
        at[: space.dimension] = edge.global_coordinates()
        middle = (at * area).sum(axis=(1, 2)) / area.sum()
        axis = np.eye(3)[AXES.index(self.about)]
        turned = np.cross(axis, at - middle[:, None, None], axisb=0, axisc=0)[: space.dimension]
        traction = turned / (np.square(turned).sum(axis=0) * area).sum()

        @skfem.LinearForm
        def pushed(test, w):
            return space.thickness * sum(test[i] * traction[i] for i in range(space.dimension))

        load = space.vector(pushed.assemble(edge))
        if not load.any():
            cure = "is clamped; choose one that can move"
            raise SceneError(f"effects.couple.edge = {self.edge!r} {cure}")
        return self.acting(load)
