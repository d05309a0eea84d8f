"""Static equilibria: the elastica, limit loads in closed form, failures that say where they
stopped.
"""

from dataclasses import replace

import numpy as np
import pytest
from scenes import BEAM, BENDING, SLENDER, quadratic_body
from scipy.integrate import simpson, solve_bvp
from scipy.optimize import brentq

from vibrom import effects
from vibrom.bodies import space
from vibrom.solvers.full import static
from vibrom.solvers.full.modes import eigenmodes, linearised
from vibrom.term import Force, SceneError, Term

YOUNG = SLENDER["young_modulus"]
STATIC = {"elasticity": SLENDER, "geometric_nonlinearity": {}}


def end_loaded(direction, **body):
    made = space.build(
        quadratic_body(
            probes={axis: {"at": [1.0, 0.01], "direction": axis} for axis in "xy"}, **body
        )
    )
    return made, effects.assemble(
        made, {**STATIC, "point_load": {"at": [1.0, 0.01], "direction": direction}}
    )


def test_elastica_under_an_end_load():
    """theta'' = -F/(EI) cos(theta), theta(0) = 0, theta'(L) = 0, unstretched; nu = 0 takes away
    what a beam does not know. Twenty elements bend the beam to within 0.2 %; shear and stretching
    are of order (h/L)^2 = 4e-4."""
    made, term = end_loaded("y", cells=[20, 1])
    s, q = np.linspace(0.0, 1.0, 2001), None
    for level in (1.0, 2.0, 5.0, 10.0):
        q = static.equilibrium(term, level * BENDING, start=q)
        curve = solve_bvp(
            lambda _, y, level=level: [y[1], -level * np.cos(y[0])],
            lambda left, right: [left[0], right[1]],
            s[::40],
            [s[::40], 1 - s[::40]],
            tol=1e-8,
        )
        angle = curve.sol(s)[0]
        expected = [simpson(np.cos(angle), x=s), simpson(np.sin(angle), x=s)]
        np.testing.assert_allclose(
            [1.0 + q[made.probes["x"]], q[made.probes["y"]]], expected, rtol=5e-3
        )
    # In one go, through steps of its own choice, to the same place.
    np.testing.assert_allclose(static.equilibrium(term, 10.0 * BENDING), q, atol=1e-6)


def test_a_compressed_bar_has_a_limit_load():
    """St. Venant-Kirchhoff bar, nu = 0: force E A l (l^2 - 1)/2 at the stretch l, extreme at l =
    1/sqrt(3).
    """
    made = space.build(
        {
            **quadratic_body(cells=[2, 1], height=0.5),
            "probes": {"end": {"at": [1.0, 0.25], "direction": "x"}},
        }
    )
    term = effects.assemble(made, {**STATIC, "follower_load": {"edge": "right", "pressure": 1.0}})
    push = term.dead_load
    term = replace(
        term, dead_load=None, forces=term.forces[:1]
    )  # pushes along x, whatever the edge does
    levels, shapes = static.path(term, push, 0.1, 40)
    stretch = 1.0 + shapes[:, made.probes["end"]]
    np.testing.assert_allclose(levels, YOUNG * stretch * (1 - stretch**2) / 2, atol=1e-6 * YOUNG)
    assert (
        stretch[-1] < 1 / np.sqrt(3) - 0.1
        and 0.99 < levels.max() / (YOUNG / (3 * np.sqrt(3))) <= 1.0 + 1e-6
    )


def test_a_clamped_beam_stretches_when_it_bends():
    """EI w'''' - T w'' = q between walls: w' = -(q/T)(x - a sinh(n x)/sinh(n a)) from the middle,
    n^2 = T/EI; its lengthening gives T = EA/(4a) int w'^2.
    """
    height, a = 0.02, 0.5
    made = space.build(
        quadratic_body(
            cells=[20, 1],
            clamped=["left", "right"],
            probes={"middle": {"at": [0.5, 0.01], "direction": "y"}},
        )
    )

    def load_and_deflection(tension):
        n = np.sqrt(tension / BENDING)
        sinh, cosh = np.sinh(n * a), np.cosh(n * a)
        square = (
            2 * a**3 / 3
            - 4 * a * (a * cosh / sinh / n - 1 / n**2)
            + a**2 * (sinh * cosh / n - a) / sinh**2
        )
        load = tension * np.sqrt(4 * a * tension / (YOUNG * 0.05 * height * square))
        return load, load / tension * (a**2 / 2 - a * (cosh - 1) / (n * sinh))

    for deflection in (0.01, 0.03):  # half and one and a half times the height
        tension = brentq(lambda t, w=deflection: load_and_deflection(t)[1] - w, 1.0, 1e7)
        gravity = {"y": -load_and_deflection(tension)[0] / (0.05 * height)}
        term = effects.assemble(made, {"inertia": {"density": 1.0}, **STATIC, "gravity": gravity})
        # Shear adds some (h/L)^2 times ten to the bending part: 0.4 %.
        assert static.equilibrium(term)[made.probes["middle"]] == pytest.approx(
            -deflection, rel=4e-3
        )


def arch_limit(rise, a, bending, stretching):
    """Uniform load [N/m] at which a shallow clamped parabolic arch of half span a snaps through.

    EI w'''' + P w'' = q - 2 r P/a^2 =: k P  with the thrust P = mu^2 EI; from the middle  w' = k (x
    - a sin(mu x)/sin(mu a)) =: k h, and the shortening gives k:  -2 a P/EA = (2 r/a^2) k int x h +
    k^2/2 int h^2. Every mu has up to two equilibria; in the order of their deflections they are the
    path.
    """
    mu = np.linspace(0.005, 1.6, 4001) * np.pi / a
    sine, cosine = np.sin(mu * a), np.cos(mu * a)
    moment = 2 * (1 / mu**2 - a * cosine / (mu * sine))  # int x sin(mu x) / sin(mu a)
    first = 2 * a**3 / 3 - a * moment
    second = 2 * a**3 / 3 - 2 * a * moment + a**2 * (a - sine * cosine / mu) / sine**2
    thrust = mu**2 * bending
    roots = [
        np.roots(each)
        for each in zip(second / 2, 2 * rise / a**2 * first, 2 * a * thrust / stretching)
    ]
    k = np.array([np.where(np.isreal(pair), pair.real, np.nan) for pair in roots]).T
    loads = k * thrust + 2 * rise * thrust / a**2
    middle = k * (a / (mu * sine) * (1 - cosine) - a**2 / 2)  # minus the deflection
    path = loads.ravel()[np.argsort(np.abs(middle).ravel())][: np.isfinite(loads).sum()]
    return path[np.nonzero((path[1:-1] > path[:-2]) & (path[1:-1] > path[2:]))[0][0] + 1]


@pytest.mark.parametrize("rise", [0.02, 0.01])
def test_a_shallow_arch_snaps_through(rise):
    """Load falls beyond the limit load and rises again; shallow theory holds within the slope's
    square, (4 r/L)^2 = 0.64 and 0.16 %.
    """
    height = rise / 2
    made = space.build(
        quadratic_body(
            cells=[40, 1],
            height=height,
            rise=rise,
            clamped=["left", "right"],
            probes={"middle": {"at": [0.5, 0.0], "direction": "y"}},
        )
    )
    term = effects.assemble(made, {"inertia": {"density": 1.0}, **STATIC, "gravity": {"y": -1.0}})
    levels, shapes = static.path(replace(term, dead_load=None), term.dead_load, 0.4 * rise, 90)
    middle = shapes[:, made.probes["middle"]]
    summit = 1 + np.nonzero((levels[1:-1] > levels[:-2]) & (levels[1:-1] > levels[2:]))[0][0]
    limit = arch_limit(rise, 0.5, YOUNG * 0.05 * height**3 / 12, YOUNG * 0.05 * height)
    assert levels[summit] * 0.05 * height == pytest.approx(
        limit, rel=(4 * rise) ** 2
    )  # the weight is 1 kg/m3 m/s2 b h a metre
    # Down to less than half of the limit load that shallow theory gives it there, and up again on
    # the other side.
    assert middle[-1] < -1.5 * rise and levels[-1] > levels[summit] > levels[summit:].min()


def test_the_part_of_the_load_that_is_carried_is_named():
    """f = tanh(u) carries no more than one: half of the load of two."""

    def force(q, v, dofs, table, f):
        f += np.tanh(q)

    def tangent(q, v, dofs, table, slots, scale_q, scale_v, values):
        values += scale_q * (1.0 - np.tanh(q) ** 2)

    term = Term(
        load=np.ones(1),
        forces=(Force(lambda width: (force, tangent), np.zeros((1, 1), int), np.zeros((1, 0))),),
    )
    with pytest.raises(
        static.NoEquilibrium,
        match=r"no static equilibrium beyond 0\.\d+ of the load \(signal = 2\).*lower the load",
    ) as caught:
        static.equilibrium(term, 2.0)
    assert 0.499 < caught.value.level <= 0.5
    assert np.tanh(caught.value.displacement[0]) == pytest.approx(
        2.0 * caught.value.level, rel=1e-7
    )


def test_wrong_shapes_are_named():
    made, term = end_loaded("y", cells=[2, 1])
    n, short = made.size, np.zeros(made.size - 1)
    wanted = rf"has shape \({n - 1},\); needed is \(n,\) = \({n},\)"
    with pytest.raises(ValueError, match="^start " + wanted):
        static.equilibrium(term, 1.0, start=short)
    with pytest.raises(ValueError, match="^load " + wanted):
        static.path(term, short, 0.1, 1)
    with pytest.raises(ValueError, match="^start " + wanted):
        static.path(term, term.load, 0.1, 1, start=short)
    with pytest.raises(ValueError, match="^count = 0; needed is at least one mode"):
        eigenmodes(effects.assemble(made, BEAM), 0)


@pytest.mark.parametrize("size", [1e155, 1e300, np.inf, np.nan])
def test_a_load_beyond_all_numbers_has_no_equilibrium(size):
    """The squares of its entries are infinite, and infinity is not above infinity."""
    made = space.build(quadratic_body(cells=[2, 1]))
    term = effects.assemble(made, {**BEAM, "geometric_nonlinearity": {}, "gravity": {}})
    heavy = replace(term, dead_load=np.full(term.size, size))
    for fails in (
        lambda: static.equilibrium(heavy),
        lambda: linearised(heavy),
        lambda: static.path(term, heavy.dead_load, 0.1, 1),
    ):
        with pytest.raises(static.NoEquilibrium, match="too large to compute with; lower it"):
            fails()


def test_a_body_that_nothing_holds_is_no_body_at_rest():
    made = space.build(quadratic_body(cells=[2, 1]))
    term = effects.assemble(made, {"inertia": {"density": 1.0}, "gravity": {}})
    with pytest.raises(SceneError, match="nothing that holds the body.*list elasticity"):
        static.equilibrium(term)
    with pytest.raises(SceneError, match="effects is empty.*list inertia and elasticity"):
        Term().size  # noqa: B018


def test_a_heavy_body_is_solved_once(monkeypatch):
    """However many effects and callers need its rest state or its modes; another weight is another
    body.
    """
    solved, equilibrium = [], static.equilibrium
    monkeypatch.setattr(static, "equilibrium", lambda term: solved.append(1) or equilibrium(term))
    made = space.build(quadratic_body(cells=[4, 1]))
    for count, y in ((1, -9.81), (2, -20.0)):
        listed = {
            **BEAM,
            "geometric_nonlinearity": {},
            "gravity": {"y": y},
            "rayleigh_damping": {"damping_ratio": 0.01},
            "modal_load": {"mode": 2},
        }
        term = effects.assemble(made, listed)
        at_rest, modes = linearised(term), eigenmodes(term, 3)
        assert len(solved) == count
        # Callers share what is remembered.
        with pytest.raises(ValueError, match="read-only"):
            at_rest.rest[0] = 0.0
        with pytest.raises(ValueError, match="read-only"):
            modes.shape *= 2.0
        np.testing.assert_allclose(modes.shape @ term.load, [0.0, 1.0, 0.0], atol=1e-9)
