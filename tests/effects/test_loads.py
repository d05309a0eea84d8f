"""Point load, base motion, gravity and follower loads against closed forms and readable forms."""

import numpy as np
import pytest
import skfem
from scenes import BEAM, BENDING, LINE, LINEAR, body, quadratic_body
from scipy.linalg import eigh
from scipy.sparse.linalg import spsolve
from skfem.helpers import dot, grad, identity

from vibrom import effects
from vibrom.bodies import space
from vibrom.solvers.full import static
from vibrom.solvers.full.modes import eigenmodes, linearised
from vibrom.solvers.full.newmark import Newmark, Record
from vibrom.term import SceneError

TIP = {"tip": {"at": [1.0, 0.01], "direction": "y"}}


def test_static_deflection_under_a_point_load():
    """Euler-Bernoulli: w = F L^3 / (3 E I); shear adds 0.03 % at slenderness 50 and the node's dent
    less.
    """
    made = space.build(quadratic_body(cells=[20, 1], probes=TIP))
    term = effects.assemble(made, {**BEAM, "point_load": {"at": [1.0, 0.01], "direction": "y"}})
    assert static.equilibrium(term, 1.0)[made.probes["tip"]] == pytest.approx(
        1.0 / (3 * BENDING), rel=1e-3
    )


@pytest.mark.parametrize(
    "effect, settings",
    [
        ("point_load", {"direction": "y"}),
        ("tip_mass", {"mass": 1.0}),
        ("cubic_spring", {"direction": "x"}),
        ("stop", {"direction": "y", "gap": 0.0, "stiffness": 1.0}),
    ],
)
def test_a_point_off_the_mesh_names_the_nearest_node(effect, settings):
    with pytest.raises(
        SceneError,
        match=rf"effects.{effect}.at = \[0.51, 0.0\] is no node of the mesh; "
        r"the nearest one is \[0.5, 0.0\]",
    ):
        effects.assemble(space.build(body()), {**LINEAR, effect: {"at": [0.51, 0.0], **settings}})


@pytest.mark.parametrize("direction", ["x", "y"])
def test_base_motion_is_that_of_a_support_that_moves(direction):
    """Harmonic motion w of the left edge: (K - Omega^2 M) of the body with its support, in absolute
    displacements, against the relative ones.
    """
    axis, omega, w = "xy".index(direction), 700.0, 1e-3
    held, loose = (
        space.build(body(cells=[8, 2], height=0.1, clamped=clamped)) for clamped in (["left"], [])
    )
    relative, absolute = (
        effects.assemble(held, {**LINEAR, "base_motion": {"direction": direction}}),
        effects.assemble(loose, LINEAR),
    )
    moved = spsolve(
        (relative.stiffness - omega**2 * relative.mass).tocsc(), relative.load * -(omega**2) * w
    )
    dynamic, place = absolute.stiffness - omega**2 * absolute.mass, loose.number[held.free]
    support = np.setdiff1d(np.arange(loose.size), place)
    prescribed = w * (loose.dof_axis[support] == axis)
    expected = spsolve(dynamic[place][:, place].tocsc(), -dynamic[place][:, support] @ prescribed)
    # Two solves with a condition number of about 1e6.
    np.testing.assert_allclose(
        moved + w * (held.dof_axis == axis), expected, atol=1e-9 * np.abs(expected).max()
    )


def hanging(pull, modes=12):
    """First frequency of a clamped beam under its own weight pulling outwards, by Ritz: (EI w'')''
    - (m g (L - x) w')' = omega^2 m w; L = m = EI = 1, m g L^3/EI = pull.
    """
    n = np.arange(2, modes + 2)
    total = n[:, None] + n
    mass, pairs = 1 / (total + 1), np.outer(n, n)
    stiffness = np.outer(n * (n - 1), n * (n - 1)) / (total - 3) + pull * pairs * (
        1 / (total - 1) - 1 / total
    )
    return np.sqrt(eigh(stiffness, mass, eigvals_only=True)[0])


def loaded_by_weight(pull, **body):
    made = space.build(quadratic_body(cells=[20, 1], probes=TIP, **body))
    return made, effects.assemble(
        made,
        {**BEAM, "geometric_nonlinearity": {}, "gravity": {"x": pull * BENDING / LINE, "y": 0.0}},
    )


@pytest.mark.parametrize("pull", [5.0, 20.0, -5.0])
def test_weight_raises_or_lowers_the_frequency_of_a_hanging_or_standing_beam(pull):
    """Ritz with monomials; slender-beam theory and stretching under weight are within 0.2 %."""
    _, term = loaded_by_weight(pull)
    assert eigenmodes(term, 1)[0][0] == pytest.approx(
        hanging(pull) * np.sqrt(BENDING / LINE), rel=2e-3
    )


def test_a_column_buckles_under_its_own_weight():
    """Greenhill 1881: m g L^3 = 7.837 EI."""
    eigenmodes(loaded_by_weight(-7.837 * 0.99)[1], 1)
    with pytest.raises(SceneError, match="the body buckles under its dead load.* lower that load"):
        eigenmodes(loaded_by_weight(-7.837 * 1.01)[1], 1)
    with pytest.raises(SceneError, match="buckles"):
        eigenmodes(loaded_by_weight(-40.0)[1], 1)  # far beyond, where no square is near zero


def test_deflection_under_weight_and_rest_there():
    """w = m g L^4 / (8 EI) while small; a motion that starts there, at rest, stays."""
    made = space.build(quadratic_body(cells=[20, 1], probes=TIP))
    term = effects.assemble(made, {**BEAM, "geometric_nonlinearity": {}, "gravity": {}})
    rest, _ = linearised(term)
    assert rest[made.probes["tip"]] == pytest.approx(-LINE * 9.81 / (8 * BENDING), rel=2e-3)
    motion = Newmark().run(term, rest[:, None], np.array([1e-4]), 50)
    assert (
        motion.outcomes == ["ok"]
        and np.abs(motion.displacement[0] - rest).max() <= 1e-6 * np.abs(rest).max()
    )


@pytest.mark.parametrize("edge", ["left", "right", "bottom", "top"])
@pytest.mark.parametrize("element", ["bilinear", "quadratic", "serendipity"])
def test_follower_load_is_that_of_the_form(element, edge):
    """Nanson: the traction on the undeformed edge is -pressure cof(F) N, tangentially shear F T;
    any deformation, held nodes too.
    """
    made = space.build(
        body(
            element=element,
            cells=[3, 2],
            height=0.3,
            clamped=["bottom" if edge != "bottom" else "top"],
        )
    )
    term = effects.assemble(made, {"follower_load": {"edge": edge, "pressure": 3.0, "shear": 5.0}})
    u, v = 0.05 * np.random.default_rng(0).standard_normal((2, made.size))

    def kernel(q):
        f, (force,) = np.zeros((made.size, 1)), term.forces
        force.kernels(1)[0](q[:, None].copy(), np.zeros((made.size, 1)), force.dofs, force.table, f)
        return term.dead_load - f[:, 0]

    boundary = skfem.FacetBasis(
        made.basis.mesh, made.basis.elem, facets=made.basis.mesh.boundaries[edge], intorder=6
    )

    @skfem.LinearForm
    def traction(test, w):
        gradient = grad(w["u"]) + identity(grad(w["u"]))
        tangent = np.einsum("ij...,j...->i...", gradient, np.array([-w.n[1], w.n[0]]))
        return made.thickness * dot(
            -3.0 * np.array([tangent[1], -tangent[0]]) + 5.0 * tangent, test
        )

    whole = np.zeros(made.basis.N)
    whole[made.free] = u
    expected = traction.assemble(boundary, u=boundary.interpolate(whole))[made.free]
    np.testing.assert_allclose(kernel(u), expected, atol=1e-13 * np.abs(expected).max() + 1e-14)
    # Linear in the displacement: one difference is the derivative.
    np.testing.assert_allclose(
        static.Body(term).tangent(u) @ v, kernel(u) - kernel(u + v), atol=1e-12
    )


def column(load, cells=(12, 1)):
    made = space.build(quadratic_body(cells=list(cells), probes=TIP))
    return made, effects.assemble(
        made,
        {
            **BEAM,
            "geometric_nonlinearity": {},
            "follower_load": {"edge": "right", "pressure": load * BENDING / (0.05 * 0.02)},
        },
    )


def test_becks_column_flutters():
    """Beck 1952: the first two frequencies of a cantilever under a tangential end load meet at
    20.05 EI/L^2, at 11.02 sqrt(EI/(m L^4)).
    """
    low, high = 15.0, 25.0
    while high - low > 0.02:
        middle = 0.5 * (low + high)
        try:
            frequencies = eigenmodes(column(middle)[1], 2)[0]
            low = middle
        except SceneError as error:
            assert "flutters under its dead load" in str(error)
            high = middle
    assert low == pytest.approx(20.05, rel=0.02)
    np.testing.assert_allclose(frequencies / np.sqrt(BENDING / LINE), 11.02, rtol=0.05)


def test_flutter_grows_as_its_eigenvalue_says():
    """Half more than Beck's load: a small motion grows as e^{s t}, s from the eigenvalues of the
    non-symmetric tangent; Newmark with the same tangent.
    """
    made, term = column(30.0, cells=(6, 1))
    rest, stiffness = linearised(term)
    squares = np.linalg.eigvals(np.linalg.solve(term.mass.toarray(), stiffness.toarray()))
    growth = np.sqrt(-squares.astype(complex)).real.max()
    steps, step = 800, 10.0 / growth / 800
    start = rest + 1e-7 * made.dof_location[:, 0] ** 2 * (made.dof_axis == 1)
    motion = Newmark(tolerance=1e-8).run(
        term, start[:, None], np.array([step]), steps, record=Record(every=1)
    )
    assert motion.outcomes == ["ok"] and motion.iterations <= 4 * steps
    size = np.linalg.norm(motion.displacement[0] - rest, axis=1)
    late = slice(steps // 2, None)
    measured = np.polyfit(step * np.arange(steps + 1)[late], np.log(size[late]), 1)[0]
    # The oscillation under the growth leaves a ripple of a few per cent on the fit over some
    # periods.
    assert measured == pytest.approx(growth, rel=0.05)
