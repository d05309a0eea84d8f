"""A body from a mesh file: Gmsh (.msh), Abaqus (.inp), or anything else that meshio reads.

    body: {mesh: part.msh, width: 0.01, clamped: [fixed], probes: {tip: {at: end, direction: y}}}

Elements in the plane make a plane body, solid ones a body in space. Physical groups, or sets, of
facets, edges and nodes are what `clamped`, probes and effects name. Lengths are in metres.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import skfem
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from vibrom.artefacts.hardware import check_memory
from vibrom.bodies.elements import KINDS, bases
from vibrom.bodies.files import read
from vibrom.bodies.space import Probe, Space, dofs_of, movable, numbered
from vibrom.bodies.topology import body_of, facets_of, meshed, points_of
from vibrom.config.digest import digest
from vibrom.config.errors import closest
from vibrom.config.kinds import Distinct, ElementOrder, Group, MeshFile, Name, NonNegative
from vibrom.term import SceneError

FLAT = 1e-7  # of the volume of an element as wide as its longest edge
HELD = 1e-9  # of the size of the body


@dataclass(frozen=True)
class Mesh:
    """A meshed body, plane or in space."""

    mesh: MeshFile  # beside the scene's file
    clamped: Distinct[Group]  # groups that cannot move
    probes: dict[Name, Probe]  # displacements that are recorded; tables show the first
    width: NonNegative = 0.0  # m, out of plane, of a plane body
    order: ElementOrder | None = None  # of the displacements; none: that of the file's elements
    digest: str = ""  # of the file; left out, that of the file as it is

    def build(self) -> Space:
        """Read, checked, numbered and watched."""
        path = Path(self.mesh)
        content = read(path)
        if self.digest and self.digest != digest(path):
            raise SceneError(
                f"body.mesh = {self.mesh} has changed since this run began; run it again"
            )
        kind, nodes, points = body_of(content, self.mesh)
        mesh, vertex = meshed(kind, nodes, points)
        boundaries = facets_of(mesh, content.groups, vertex, self.mesh)
        mesh = mesh.with_boundaries(boundaries)
        kind = self._kind(kind)
        entries = mesh.t.shape[1] * (mesh.dim() * KINDS[kind].element().doflocs.shape[0]) ** 2
        check_memory(3 * 8 * entries, f"a mesh of {mesh.t.shape[1]} elements", "mesh it coarser")
        check_shapes(mesh, self.mesh)
        basis, scalar, mass = bases(mesh, kind)
        groups = points_of(basis, content.groups, vertex, boundaries)
        self._check_names({**groups, **boundaries})
        free = numbered(scalar, basis, movable(basis, self.clamped, groups))
        clamped, width = tuple(self.clamped), self._width(mesh.dim())
        space = Space(basis, scalar, width, clamped, free, basis.doflocs, {}, mass, groups)
        check_held(space)
        return space.watched(self.probes)

    def _kind(self, kind: str) -> str:
        """Of the displacements."""
        own = 1 if KINDS[kind].second or kind == "wedge" else 2
        if self.order is None or self.order == own:
            return kind
        if self.order < own:
            raise SceneError(
                f"body.order = {self.order} is below that of the file's {KINDS[kind].words}; leave "
                "it out"
            )
        if not KINDS[kind].second:
            raise SceneError(f"body.order = {self.order}: {KINDS[kind].words} have order 1 only")
        return KINDS[kind].second

    def _width(self, dim: int) -> float:
        if dim == 2 and not self.width:
            raise SceneError("body.width is missing; a plane body needs one (m, out of plane)")
        if dim == 3 and self.width:
            raise SceneError(
                f"body.width = {self.width:g} has no meaning for a body in space; leave it out"
            )
        return self.width if dim == 2 else 1.0

    def _check_names(self, known: dict[str, np.ndarray]) -> None:
        for place, name in enumerate(self.clamped):
            if name not in known:
                raise SceneError(
                    f"body.clamped[{place}] = {name!r} is no group of {self.mesh}; "
                    f"{closest(name, known)}"
                )


def check_shapes(mesh: skfem.Mesh, path: str) -> None:
    """Raises SceneError where elements are flat or turned inside out, or the body is in parts."""
    mapping, nodes = mesh.mapping(), mesh.elem().doflocs.T
    inside = mesh.elem.refdom.p.mean(axis=1)[:, None]
    places = np.concatenate([inside, inside + 0.999 * (nodes - inside)], axis=1)
    jacobian = np.linalg.det(np.moveaxis(mapping.DF(places), (0, 1), (-2, -1)))
    edges = mesh.p[:, mesh.t[:, None]] - mesh.p[:, mesh.t[None, :]]
    longest = np.linalg.norm(edges, axis=0).max(axis=(0, 1))
    flat = np.abs(jacobian).min(axis=1) <= FLAT * longest ** mesh.dim()
    turned = jacobian.min(axis=1) * jacobian.max(axis=1) < 0.0
    for wrong, words in ((turned, "turned inside out"), (flat, "flat")):
        if wrong.any():
            first = np.flatnonzero(wrong)[0]
            near = [float(f"{x:.4g}") for x in mesh.p[:, mesh.t[:, first]].mean(axis=1)]
            raise SceneError(
                f"body.mesh = {path}: {wrong.sum()} elements are {words}, the first one near "
                f"{near}; mesh the body once more"
            )
    across = mesh.f2t[:, mesh.f2t[1] >= 0]
    graph = coo_matrix((np.ones(across.shape[1]), across), shape=(mesh.nelements,) * 2)
    parts = connected_components(graph, directed=False)[0]
    if parts > 1:
        raise SceneError(
            f"body.mesh = {path} is {parts} parts that share no side of an element; give one, or "
            "merge the nodes that they share"
        )


def check_held(space: Space) -> None:
    """Raises SceneError where what is clamped lets the body turn: one point, or a line in space."""
    held = [dofs_of(space.basis, name, space.groups) for name in space.clamped]
    if not held:
        return
    place = space.basis.doflocs[:, np.concatenate(held)]
    spread = np.linalg.svd(place - place.mean(axis=1)[:, None], compute_uv=False)
    size = np.ptp(space.basis.mesh.p, axis=1).max()
    if (spread > HELD * size).sum() < space.dimension - 1:
        what = "a point" if space.dimension == 2 or spread.max() <= HELD * size else "a line"
        raise SceneError(
            f"body.clamped = {list(space.clamped)} is {what} about which the body turns freely; "
            "clamp more"
        )
