"""Factors of wide matrices, and what rests on them, against dense algebra and the band."""

from dataclasses import replace

import numpy as np
import pytest
from scenes import LINEAR, UNDAMPED, body
from scipy.linalg import eigh
from scipy.sparse import csc_matrix

from vibrom import effects
from vibrom.bodies import space
from vibrom.solvers.full import factors, static
from vibrom.solvers.full.modes import eigenmodes
from vibrom.solvers.full.newmark import Newmark, Record
from vibrom.solvers.full.tangent import Pardiso
from vibrom.term import Term

TIP = {"tip": {"at": [1.0, 0.2, 0.2], "direction": "y"}}
BLOCK = {"shape": "block", "height": 0.2, "width": 0.2, "element": "trilinear"}


@pytest.fixture
def wide(monkeypatch):
    """A body that is taken for a wide one."""
    monkeypatch.setattr(factors, "WIDE", 20)
    return space.build(body(**BLOCK, cells=[3, 2, 2], probes=TIP))


def matrix(n, shift):
    rng = np.random.default_rng(0)
    dense = rng.standard_normal((n, n)) * (rng.random((n, n)) < 0.1)
    return csc_matrix(dense + dense.T + shift * np.eye(n))


@pytest.mark.parametrize("shift, kind", [(60.0, factors.Cholesky), (0.0, None)])
@pytest.mark.parametrize("columns", [(), (3,)])
def test_solutions_are_those_of_dense_algebra(shift, kind, columns):
    """Positive definite in the band, indefinite without it."""
    a = matrix(300, shift)
    made, b = factors.factor(a, symmetric=True), np.random.default_rng(1).random((300, *columns))
    assert isinstance(made, factors.Cholesky) == (kind is not None)
    found = made.solve(b)
    assert np.abs(a @ found - b).max() <= 1e-10 * np.abs(found).max() * abs(a).max()


def test_pardiso_factorises_each_matrix_of_a_pattern():
    pytest.importorskip("pypardiso")
    made, b = Pardiso(), np.random.default_rng(1).random((300, 2))
    for times in (1.0, 3.0):
        a = times * matrix(300, 60.0)
        assert np.abs(a @ made(a).solve(b) - b).max() <= 1e-13


def test_a_band_without_room_is_no_band(monkeypatch):
    monkeypatch.setattr(factors, "ROOM", 1000)
    assert not isinstance(factors.factor(matrix(300, 60.0), symmetric=True), factors.Cholesky)


def test_modes_and_statics_of_a_wide_body(wide):
    term = effects.assemble(wide, {**LINEAR, "point_load": TIP["tip"]})
    assert factors.is_wide(term.stiffness)
    found = eigenmodes(term, 4)
    squares = eigh(
        term.stiffness.toarray(), term.mass.toarray(), eigvals_only=True, subset_by_index=[0, 3]
    )
    np.testing.assert_allclose(found.frequency**2, squares, rtol=1e-8)
    q = static.equilibrium(term, 2.0)
    expected = np.linalg.solve(term.stiffness.toarray(), 2.0 * term.load)
    np.testing.assert_allclose(q, expected, atol=1e-10 * np.abs(expected).max())


def test_steps_with_sparse_factors_are_those_in_the_band(wide):
    term = effects.assemble(wide, UNDAMPED)
    mode = eigenmodes(term, 1)
    start = (1e-3 * mode.shape[0] / np.abs(mode.shape[0]).max())[:, None]
    h = np.array([2 * np.pi / mode.frequency[0] / 100])
    runs = [
        replace(Newmark(tolerance=1e-9), widest_band=bound).run(
            term, start, h, 20, record=Record(every=20)
        )
        for bound in (0, 10**6)
    ]
    assert all(run.outcomes == ["ok"] for run in runs)
    ours, theirs = (run.displacement[0, -1] for run in runs)
    # Twenty steps, each converged to 1e-9 of its forces.
    np.testing.assert_allclose(ours, theirs, atol=1e-6 * np.abs(theirs).max())


def test_how_wide_a_band_may_be_depends_on_the_dimension():
    """Factors of bodies in space fill more; what is asked for is taken."""
    plane, solid = (Term(elastic=np.eye(strains)) for strains in (3, 6))
    assert Newmark().is_wide(plane, 550) and not Newmark().is_wide(solid, 440)
    assert not Newmark().is_wide(plane, 250) and Newmark().is_wide(solid, 650)
    assert Newmark(widest_band=3).is_wide(solid, 4) and not Newmark(widest_band=9).is_wide(plane, 9)
