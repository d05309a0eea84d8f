"""Bodies of any mesh on a page: plane ones as they are, solid ones by their surface."""

import numpy as np
import pytest
import xarray as xr
from meshes import spaced, straight

from vibrom.report.drawing import body
from vibrom.steps.structure import geometry


def structure(kind, **shape):
    return xr.Dataset(geometry(spaced(straight(kind, **shape), kind)))


def area(polygons):
    x, y = np.moveaxis(polygons, -1, 0)
    return np.abs((x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1)).sum(axis=1)) / 2


@pytest.mark.parametrize("kind", ["triangle", "triangle6", "quad8"])
def test_elements_of_a_plane_body_cover_it(kind):
    known = structure(kind)
    cells, order = body.polygons(known, np.zeros(known.sizes["dof"]))
    assert area(cells).sum() == pytest.approx(0.8) and np.array_equal(order, np.arange(len(cells)))
    (loop,) = body.outline(known)
    assert len(loop) == 7 and loop[0] == loop[-1]  # the six vertices of 2 x 1 cells


@pytest.mark.parametrize("kind", ["tetra", "tetra10", "hexahedron", "hexahedron27", "wedge"])
def test_a_solid_body_is_drawn_by_its_surface(kind):
    """Its faces cover its shadow twice, front and back; the nearest are last. The edges of a block
    of 2 x 1 x 1 cells are 16.
    """
    known = structure(kind)
    cells, order = body.polygons(known, np.zeros(known.sizes["dof"]))
    view = body.view(known)
    np.testing.assert_allclose(view @ view.T, np.eye(2), atol=1e-15)
    toward = np.cross(*view)
    # A face's shadow is its area times the cosine between its normal and the view.
    shadow = 2 * np.abs(toward) @ [0.8 * 0.6, 1.0 * 0.6, 1.0 * 0.8]
    assert area(cells).sum() == pytest.approx(shadow)
    middles = known["node"].values[known["face_node"].values[order]].mean(axis=1)
    assert (np.diff(middles @ toward) >= -1e-12).all()
    edges = body.outline(known)
    assert len(edges) == 16
    ends = known["node"].values[np.array(edges)]
    assert np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1).sum() == pytest.approx(4 * 2.4)


def test_a_displacement_is_seen_from_where_the_body_is():
    """A translation moves all edges by its projection, but the clamped nodes."""
    known = structure("hexahedron")
    moved = np.where(known["dof_axis"].values == 2, 0.1, 0.0)
    still, there = (np.array(body.outlines(known, times * moved)) for times in (0, 1))
    nodes = np.array(body.outline(known))
    free = known["node"].values[nodes, 0] > 1e-9
    expected = 0.1 * free[..., None] * body.view(known)[:, 2]
    np.testing.assert_allclose(there - still, expected, atol=1e-15)
    assert free.any() and not free.all()
