"""The finite-element space of a body: what is clamped, what can move, and where it is watched.

Everything about shape functions, quadrature, named boundaries and degrees of freedom comes from
scikit-fem; the bodies and `effects/` are its only users.
"""

from __future__ import annotations

import importlib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import skfem
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import reverse_cuthill_mckee

from vibrom.config.errors import closest
from vibrom.config.instance import instance, plug
from vibrom.config.kinds import Direction, PlaneDirection, PlanePoint, Point
from vibrom.config.scene import shape_of
from vibrom.term import SceneError

AXES = ("x", "y", "z")
ON_NODE = 1e-6  # of the smallest edge of the mesh: farther away a point is no node


@dataclass(frozen=True)
class Probe:
    """A displacement that is recorded."""

    at: Point  # m, a node, or its name
    direction: Direction


@dataclass(frozen=True)
class PlaneProbe:
    """The same of a body that is known to be plane."""

    at: PlanePoint  # m, a node
    direction: PlaneDirection


@dataclass(frozen=True)
class Space:
    """A meshed body, with scikit-fem's numbers of its degrees of freedom."""

    basis: skfem.Basis  # vector-valued, with the quadrature of the stiffness
    scalar: skfem.Basis  # the same element, one component
    thickness: float  # m of a plane body, 1 of one in space
    clamped: tuple[str, ...]  # names of the groups that cannot move
    free: np.ndarray  # (n,) scikit-fem's number of each free dof
    named: np.ndarray  # (dim, N) m, the coordinates by which points are named, of all dofs
    probes: dict[str, int]  # name -> free dof
    mass: skfem.Basis | None = None  # with the quadrature of the mass, where that is another one
    groups: Mapping[str, np.ndarray] = field(
        default_factory=dict
    )  # name -> dofs, beside boundaries

    @property
    def size(self) -> int:
        """n, free displacements."""
        return len(self.free)

    @property
    def dimension(self) -> int:
        """2 or 3."""
        return self.basis.mesh.dim()

    def matrix(self, full: Any) -> csr_matrix:
        """An assembled matrix on the free dofs."""
        return csr_matrix(full)[self.free][:, self.free].tocsr()

    def vector(self, full: np.ndarray) -> np.ndarray:
        """An assembled vector on the free dofs."""
        return np.asarray(full)[self.free]

    @property
    def number(self) -> np.ndarray:
        """(N,) the free dof of each of scikit-fem's, -1 where it is clamped."""
        number = np.full(self.basis.N, -1, dtype=np.int64)
        number[self.free] = np.arange(self.size)
        return number

    @property
    def element_dofs(self) -> np.ndarray:
        """(elements, d) free dof of each local dof, -1 where clamped; local dof a dim + i is
        component i of shape function a.
        """
        return np.ascontiguousarray(self.number[self.basis.element_dofs].T)

    @property
    def axis(self) -> np.ndarray:
        """(N,) direction of each of scikit-fem's dofs: 0 along x, 1 along y, 2 along z."""
        axis = np.empty(self.basis.N, dtype=np.int64)
        axis[self.basis.element_dofs] = (np.arange(self.basis.Nbfun) % self.dimension)[:, None]
        return axis

    @property
    def dof_axis(self) -> np.ndarray:
        """(n,) direction of each free dof."""
        return self.axis[self.free]

    @property
    def dof_location(self) -> np.ndarray:
        """(n, dim) where each free dof sits [m]."""
        return self.basis.doflocs[:, self.free].T

    @property
    def dof_vertex(self) -> np.ndarray:
        """(n,) vertex of the mesh at which each free dof sits, -1 for those between vertices."""
        vertex = np.full(self.basis.N, -1, dtype=np.int64)
        vertex[self.basis.nodal_dofs] = np.arange(self.basis.mesh.nvertices)
        return vertex[self.free]

    def segments(self, boundary: str) -> np.ndarray:
        """(segments, k, 2) scikit-fem's dofs (x and y) of the k = 2 or 3 nodes of each segment of
        a named boundary of a plane body, which lies on their left.
        """
        mesh, facets = self.basis.mesh, self.basis.mesh.boundaries[boundary]
        first, last = mesh.p[:, mesh.facets[:, facets]].transpose(1, 0, 2)
        middle = mesh.p[:, mesh.t[:, mesh.f2t[0, facets]]].mean(axis=1)
        (dx, dy), (to_x, to_y) = last - first, middle - first
        ends = mesh.facets[:, facets]
        ends = np.where(dx * to_y - dy * to_x > 0, ends, ends[::-1])
        nodes = [self.basis.nodal_dofs[:, ends[0]], self.basis.nodal_dofs[:, ends[1]]]
        if len(self.basis.facet_dofs):
            nodes.insert(1, self.basis.facet_dofs[:, facets])
        return np.stack(nodes).transpose(2, 0, 1)

    @property
    def surface(self) -> np.ndarray:
        """(faces, corners) vertices around each face of a body in space; a triangle of a wedge has
        its first one twice.
        """
        mesh = self.basis.mesh
        facets = mesh.boundary_facets()
        element, around = mesh.f2t[0, facets], np.array(mesh.elem.refdom.facets)
        local = np.argmax(mesh.t2f[:, element] == facets, axis=0)
        return mesh.t[around[local].T, element].T

    def boundary(self, key: str, name: str) -> np.ndarray:
        """The facets of a named boundary, for the entry `key` of the scene."""
        known = self.basis.mesh.boundaries or {}
        if name not in known:
            what = "a group of points" if name in self.groups else "no boundary of the body"
            raise SceneError(f"{key} = {name!r} is {what}; {closest(name, known)}")
        return known[name]

    def along(self, key: str, direction: str) -> int:
        """The axis of a direction, for the entry `key` of the scene."""
        axes = AXES[: self.dimension]
        if direction not in axes:
            raise SceneError(
                f"{key} = {direction!r} is not in the body; {closest(direction, axes)}"
            )
        return axes.index(direction)

    def dof(self, key: str, at: Sequence[float] | str, direction: str) -> int:
        """The free dof at a point, or at a node of this name, for the entry `key` of the scene."""
        axes = AXES[: self.dimension]
        if direction not in axes or not (isinstance(at, str) or len(at) == len(axes)):
            raise SceneError(
                f"{key} = {at if isinstance(at, str) else list(at)} along {direction!r} is not in "
                f"the body; give {', '.join(axes)} of a node and one of these directions"
            )
        along = np.flatnonzero(self.axis == axes.index(direction))
        shown = repr(at) if isinstance(at, str) else list(at)
        chosen = self._named if isinstance(at, str) else self._nearest
        dof = chosen(key, at, along)
        for boundary in self.clamped:
            if dof in dofs_of(self.basis, boundary, self.groups):
                raise SceneError(
                    f"{key}.at = {shown} lies on the clamped boundary {boundary} and cannot "
                    "move; choose another node"
                )
        return int(self.number[dof])

    def _nearest(self, key: str, at: Sequence[float], along: np.ndarray) -> int:
        distance = np.linalg.norm(self.named[:, along].T - np.asarray(at, float), axis=1)
        nearest = along[np.argmin(distance)]
        if distance.min() > ON_NODE * shortest_edge(self.basis.mesh):
            node = [float(f"{x:.9g}") for x in self.named[:, nearest]]
            raise SceneError(
                f"{key}.at = {list(at)} is no node of the mesh; the nearest one is {node}"
            )
        return nearest

    def _named(self, key: str, at: str, along: np.ndarray) -> int:
        known = {**self.groups, **(self.basis.mesh.boundaries or {})}
        if at not in known:
            raise SceneError(f"{key}.at = {at!r} is no group of the mesh; {closest(at, known)}")
        found = np.intersect1d(dofs_of(self.basis, at, self.groups), along)
        if len(found) != 1:
            raise SceneError(
                f"{key}.at = {at!r} is a group of {len(found)} nodes; name one of a single node, "
                "or give its coordinates"
            )
        return found[0]

    def watched(self, probes: Mapping[str, Probe | PlaneProbe]) -> Space:
        """The same with these probes."""
        found = {
            name: self.dof(f"body.probes.{name}", probe.at, probe.direction)
            for name, probe in probes.items()
        }
        return replace(self, probes=found)


def shortest_edge(mesh: skfem.Mesh) -> float:
    """Of all elements [m]."""
    ends = mesh.p[:, mesh.facets if mesh.dim() == 2 else mesh.edges]
    return float(np.linalg.norm(ends[:, 0] - ends[:, 1], axis=0).min())


def dofs_of(basis: skfem.Basis, name: str, groups: Mapping[str, np.ndarray]) -> np.ndarray:
    """Scikit-fem's dofs of a group or boundary."""
    return groups[name] if name in groups else basis.get_dofs(name).all()


def movable(
    basis: skfem.Basis, clamped: Iterable[str], groups: Mapping[str, np.ndarray] | None = None
) -> np.ndarray:
    """Scikit-fem's dofs that lie on none of these boundaries or groups, in its order."""
    held = [dofs_of(basis, name, groups or {}) for name in clamped]
    free = np.setdiff1d(np.arange(basis.N), np.concatenate(held) if held else [])
    if len(free) < 2:
        raise SceneError("body.clamped leaves nothing to move; clamp less, or take more elements")
    return free


def numbered(scalar: skfem.Basis, basis: skfem.Basis, free: np.ndarray) -> np.ndarray:
    """Scikit-fem's free dofs node by node, so that matrices are narrow bands: along the body from
    one slice to the next, or in the order of reverse Cuthill and McKee where that is narrower.
    """
    dim, nodes, at = basis.mesh.dim(), scalar.element_dofs, scalar.doflocs
    extent = np.ptp(at, axis=1)
    slices = np.lexsort(np.round(at[np.argsort(extent)] / extent.max(), 9))
    pairs = np.broadcast_arrays(nodes[:, None], nodes[None])
    row, column = (part.ravel() for part in pairs)
    graph = csr_matrix((np.ones(len(row), np.int8), (row, column)), shape=(scalar.N, scalar.N))
    places = []
    for order in (slices, reverse_cuthill_mckee(graph, symmetric_mode=True)):
        place = np.empty(scalar.N, np.int64)
        place[order] = np.arange(scalar.N)
        places.append(place)
    place = min(places, key=lambda place: np.ptp(place[nodes], axis=0).max())
    of_node = np.empty((basis.N,), np.int64)
    for i in range(dim):
        of_node[basis.element_dofs[i::dim]] = dim * place[nodes] + i
    return free[np.argsort(of_node[free])]


def build(body: Mapping[str, Any]) -> Space:
    """The space of a scene's `body` block."""
    kind = plug(importlib.import_module(f"vibrom.bodies.{shape_of(body)}"), "build", SceneError)
    settings = {key: value for key, value in body.items() if key != "shape"}
    return instance(kind, settings, "body", SceneError).build()
