"""The stiffness of a deformed body without what its stresses add."""

import numpy as np
from few_dofs import TWO_MASS, TWO_STIFFNESS, two
from scenes import THESIS, body
from scipy.linalg import eigvalsh
from scipy.sparse import csc_matrix

from vibrom import effects
from vibrom.bodies import space
from vibrom.solvers.full.material import Material
from vibrom.solvers.full.static import Body

SCALE = 3.0


def dense(material, q, scale):
    entries = material.at(q[None], scale)[0], (material.row, material.column)
    lower = csc_matrix(entries, shape=(material.n, material.n)).toarray()
    return lower + np.tril(lower, -1).T


def test_two_displacements_by_hand():
    """e = (u_1/3 ... ) of `few_dofs.two_springs`: strains and their slopes written out."""
    u, w = 0.7, -0.4
    # e_1 = u_2 term linear (1/3) and u_1^2, e_2 = u_1 u_2
    slope = np.array([[2 * u, 1 / 3], [w, u]])
    still = np.array([[0.0, 1 / 3], [0.0, 0.0]])
    moduli = np.diag([1.5, 0.4])
    expected = SCALE * TWO_MASS + TWO_STIFFNESS
    expected = expected + slope.T @ moduli @ slope - still.T @ moduli @ still
    material = Material(two())
    np.testing.assert_allclose(dense(material, np.array([u, w]), SCALE), expected, rtol=1e-14)
    r = np.array([1.0, -2.0])
    found = material.solve(np.array([[u, w]]), r[None], SCALE)[0]
    np.testing.assert_allclose(found, np.linalg.solve(expected, r), rtol=1e-12)


def test_a_beam_at_rest_has_its_tangent_and_compressed_it_stays_positive():
    beam = space.build(body(cells=[6, 1]))
    term = effects.assemble(beam, THESIS)
    material, own = Material(term), Body(term)
    rest = np.zeros(term.size)
    tangent = own.tangent(rest).toarray()
    np.testing.assert_allclose(
        dense(material, rest, 0.0), tangent, atol=1e-9 * np.abs(tangent).max()
    )
    # A twentieth shorter, many times what buckles it.
    shorter = np.where(beam.dof_axis == 0, -0.05 * beam.dof_location[:, 0], 0.0)
    assert eigvalsh(own.tangent(shorter).toarray())[0] < 0.0
    assert eigvalsh(dense(material, shorter, 0.0))[0] > 0.0
