"""Tip mass, cubic spring and stop against closed forms: frequency equation, Duffing's period, an
elastic impact and one with losses.
"""

import numpy as np
import pytest
from scenes import BEAM, BENDING, LINE, LINEAR, SLENDER, body, quadratic_body
from scipy.optimize import brentq
from scipy.special import ellipk

from vibrom import effects
from vibrom.bodies import space
from vibrom.solvers.full.modes import eigenmodes
from vibrom.solvers.full.newmark import Newmark, Record
from vibrom.term import SceneError

TIP, AT = {"tip": {"at": [1.0, 0.01], "direction": "y"}}, [1.0, 0.01]


@pytest.mark.parametrize(
    "effect",
    [
        {"cubic_spring": {"linear": 2.0, "cubic": 3.0}},
        {"stop": {"gap": 0.1, "stiffness": 5.0, "side": "negative", "damping": 0.2}},
    ],
)
def test_tangent_is_the_derivative_of_the_force_for_each_state(effect):
    """States side by side: pushed in, pulled back so fast that nothing holds it, and away from the
    stop.
    """
    ((name, settings),) = effect.items()
    made = space.build(quadratic_body(cells=[1, 1], probes=TIP))
    (force,), dof = (
        effects.assemble(made, {name: {"at": AT, "direction": "y", **settings}}).forces,
        made.probes["tip"],
    )
    q, v = np.zeros((2, made.size, 4))
    q[dof], v[dof] = [-0.4, -0.3, -0.2, 0.3], [1.0, -2.0, 9.0, -1.0]
    apply, tangent = force.kernels(4)

    def at(q, v):
        f = np.zeros_like(q)
        apply(q, v, force.dofs, force.table, f)
        return f[dof]

    step, move = 1e-6, np.eye(made.size)[:, [dof]] + np.zeros(4)
    scale_q, scale_v, values = (
        np.array([1.0, 2.0, 3.0, 4.0]),
        np.array([0.5, 0.0, 1.0, 2.0]),
        np.zeros((1, 4)),
    )
    tangent(q, v, force.dofs, force.table, np.zeros((1, 1), int), scale_q, scale_v, values)
    expected = (
        at(q + step * scale_q * move, v + step * scale_v * move)
        - at(q - step * scale_q * move, v - step * scale_v * move)
    ) / (2 * step)
    np.testing.assert_allclose(values[0], expected, atol=1e-8)
    assert name == "cubic_spring" or (np.flatnonzero(values[0]) == [0, 1]).all()


@pytest.mark.parametrize("ratio", [0.5, 5.0])
def test_frequencies_with_a_tip_mass(ratio):
    """1 + cos b cosh b + r b (cos b sinh b - sin b cosh b) = 0,  omega = b^2 sqrt(EI/(m L^4)), r =
    tip mass over beam mass.
    """
    term = effects.assemble(
        space.build(quadratic_body(cells=[20, 1])),
        {**BEAM, "tip_mass": {"at": AT, "mass": ratio * LINE}},
    )

    def equation(b):
        return (
            1
            + np.cos(b) * np.cosh(b)
            + ratio * b * (np.cos(b) * np.sinh(b) - np.sin(b) * np.cosh(b))
        )

    roots = [brentq(equation, *bracket) for bracket in ((0.1, 2.0), (3.2, 4.6))]
    # Shear and rotary inertia, absent from the equation, lower the second by some (h/L)^2 b^2 = 0.6
    # %.
    np.testing.assert_allclose(
        eigenmodes(term, 2)[0], np.square(roots) * np.sqrt(BENDING / LINE), rtol=6e-3
    )
    assert eigenmodes(term, 1)[0][0] == pytest.approx(
        roots[0] ** 2 * np.sqrt(BENDING / LINE), rel=1e-3
    )


@pytest.mark.parametrize("excess", [0.01, 100.0])
def test_a_spring_that_pushes_away_harder_than_the_beam_holds_has_no_modes(excess):
    """The beam holds its tip with 3 EI/L^3: just beyond it, and far beyond, where no square is near
    zero.
    """
    made = space.build(quadratic_body(cells=[20, 1]))

    def pushed(part):
        return effects.assemble(
            made,
            {**BEAM, "cubic_spring": {"at": AT, "direction": "y", "linear": -3 * BENDING * part}},
        )

    assert eigenmodes(pushed(0.99), 1)[0][0] > 0.0
    with pytest.raises(
        SceneError, match="buckles under a negative stiffness.* raise it, as cubic_spring.linear"
    ):
        eigenmodes(pushed(1 + excess), 1)


def test_a_negative_square_that_a_factor_does_not_see_is_no_frequency(monkeypatch):
    """What is indefinite by less than rounding passes the factorisation; its root would be NaN."""
    monkeypatch.setattr("vibrom.solvers.full.modes._positive", lambda matrix: True)
    term = effects.assemble(
        space.build(quadratic_body(cells=[20, 1])),
        {**BEAM, "cubic_spring": {"at": AT, "direction": "y", "linear": -3.03 * BENDING}},
    )
    with pytest.raises(SceneError, match="buckles"):
        eigenmodes(term, 1)


@pytest.mark.parametrize("hardening", [3.0, -0.6])
def test_backbone_of_a_cubic_spring_is_duffings(hardening):
    """x'' + w^2 x + g x^3 = 0 from x = A at rest: T = 4 K(m)/sqrt(w^2 + g A^2), m = g A^2 / (2 (w^2
    + g A^2)).

    A mass of a hundred beams at the tip leaves one mode; the beam's second one follows statically,
    which the mass ratio makes a matter of 1e-4.
    """
    made = space.build(quadratic_body(cells=[8, 1], probes=TIP))
    bare = {
        **BEAM,
        "tip_mass": {"at": AT, "mass": 100 * LINE},
        "cubic_spring": {"at": AT, "direction": "y", "linear": 2 * BENDING, "cubic": 0.0},
    }
    (omega,), (mode,) = eigenmodes(effects.assemble(made, bare), 1)
    tip = made.probes["tip"]
    cubic = hardening * omega**2 / mode[tip] ** 2 / 0.1**2  # g A^2 / w^2 = hardening at A = 0.1 m
    term = effects.assemble(
        made,
        {
            **bare,
            "cubic_spring": {"at": AT, "direction": "y", "linear": 2 * BENDING, "cubic": cubic},
        },
    )
    for amplitude in (0.05, 0.1):
        start, count = amplitude * mode / mode[tip], 400
        motion = Newmark(tolerance=1e-9).run(
            term,
            start[:, None],
            np.array([2 * np.pi / omega / count]),
            2 * count,
            record=Record(start=2 * count, probes=np.array([tip])),
        )
        x = motion.probes[0, 0]
        crossings = np.nonzero(np.signbit(x[:-1]) != np.signbit(x[1:]))[0]
        times = (
            (crossings + x[crossings] / (x[crossings] - x[crossings + 1]))
            * 2
            * np.pi
            / omega
            / count
        )
        part = hardening * (amplitude / 0.1) ** 2
        period = 4 * ellipk(part / (2 * (1 + part))) / (omega * np.sqrt(1 + part))
        # Newmark's period error (omega h)^2/12 is 2e-5, times four where the spring has quadrupled
        # the stiffness.
        assert 2 * (times[1] - times[0]) == pytest.approx(period, rel=3e-4)


def block(stiffness, damping=0.0, speed=1.0, side="positive", steps=400):
    """A free block of 1 kg that flies along x into a stop 0.01 m away, for twice the time in
    contact beyond it; contact lasts `steps` steps.
    """
    made = space.build(quadratic_body(cells=[1, 1], height=1.0, width=1.0, clamped=[]))
    sign, face = (1, 1.0) if side == "positive" else (-1, 0.0)
    term = effects.assemble(
        made,
        {
            "inertia": {"density": 1.0},
            "elasticity": {**SLENDER, "young_modulus": 1e5 * stiffness},
            "stop": {
                "at": [face, 0.5],
                "direction": "x",
                "gap": 0.01,
                "stiffness": stiffness,
                "side": side,
                "damping": damping,
            },
        },
    )
    contact = np.pi / np.sqrt(stiffness)
    velocity = sign * speed * (made.dof_axis == 0)
    step = contact / steps
    total = round((0.01 / speed + 2 * contact) / step)
    motion = Newmark(tolerance=1e-9).run(
        term, np.zeros((made.size, 1)), np.array([step]), total, velocity=velocity[:, None]
    )
    assert motion.outcomes == ["ok"]
    along = term.carried[:, 0]
    return (
        step * motion.kept,
        sign * motion.displacement[0] @ along,
        sign * motion.velocity[0] @ along,
    )


@pytest.mark.parametrize("side", ["positive", "negative"])
def test_an_elastic_impact_lasts_half_a_period_and_returns_the_speed(side):
    """Depth v sqrt(m/k), time pi sqrt(m/k). The block is 1e5 times stiffer than the stop: ringing
    keeps about 1e-3 of the speed.
    """
    t, x, v = block(1e4, side=side)
    assert v[-1] == pytest.approx(-1.0, rel=2e-3)
    assert x.max() - 0.01 == pytest.approx(1e-2, rel=2e-3)
    inside = t[x > 0.01]
    assert inside[-1] - inside[0] == pytest.approx(np.pi / 100, rel=1e-2)


def test_an_impact_with_losses_returns_less():
    """v dv/(1 + c v) = -(k/m) d dd on the way in and out: g(v) = g(-e v) with g(v) = c v - ln(1 + c
    v); small c gives e = 1 - 2 c v/3.
    """
    for rate in (0.05, 0.5):
        _, _, v = block(1e4, damping=rate)
        lost = rate - np.log1p(rate)
        back = brentq(lambda e, c=rate, g=lost: -c * e - np.log1p(-c * e) - g, 0.1, 1.0)
        # As without losses, ringing keeps about 1e-3 of the speed.
        assert -v[-1] == pytest.approx(back, abs=2e-3)


def test_energy_in_contact_is_kept_to_second_order():
    """A beam released against an elastic stop: kinetic + strain + k d^2/2, before, during and after
    contacts.
    """
    made = space.build(quadratic_body(cells=[4, 1], probes=TIP))
    stop = {"at": AT, "direction": "y", "gap": 0.01, "stiffness": 20 * BENDING, "side": "negative"}
    term = effects.assemble(made, {**BEAM, "tip_mass": {"at": AT, "mass": 10 * LINE}, "stop": stop})
    (omega,), (mode,) = eigenmodes(term, 1)
    start, tip, worst, end = 0.05 * mode / mode[made.probes["tip"]], made.probes["tip"], [], []
    for count in (500, 1000, 2000, 4000):
        motion = Newmark(tolerance=1e-9).run(
            term, start[:, None], np.array([2 * np.pi / omega / count]), count
        )
        q, v = motion.displacement[0], motion.velocity[0]
        stored = 0.5 * stop["stiffness"] * np.maximum(-q[:, tip] - 0.01, 0.0) ** 2
        energy = (
            0.5 * np.einsum("ti,ti->t", v, (term.mass @ v.T).T)
            + 0.5 * np.einsum("ti,ti->t", q, (term.stiffness @ q.T).T)
            + stored
        )
        assert stored.max() > 0.3 * energy[0] and stored[-1] == 0.0
        worst.append(np.abs(energy / energy[0] - 1).max())
        end.append(abs(energy[-1] / energy[0] - 1))
    # Where within a step a contact begins and ends scatters the constant, so the order is that of
    # the whole eightfold refinement.
    assert worst[0] < 1e-2 and worst[0] / worst[-1] > 8**1.5


def test_an_effect_that_acts_more_than_once_is_a_list():
    """Two stops and two masses are what they would be one by one; springs at one node add up."""
    made = space.build(body(cells=[4, 1]))
    at = {"at": [1.0, 0.02], "direction": "y"}
    stops = [
        {**at, "gap": 0.01, "stiffness": 1e5},
        {**at, "gap": 0.02, "stiffness": 1e5, "side": "negative"},
    ]
    masses = [{"at": [1.0, 0.0], "mass": 1.0}, {"at": [0.5, 0.0], "mass": 2.0}]
    term = effects.assemble(made, {**LINEAR, "stop": stops, "tip_mass": masses})
    alone = effects.assemble(made, LINEAR)
    dof = made.dof("it", *at.values())
    q, f = np.zeros((made.size, 2)), np.zeros((made.size, 2))
    q[dof] = 0.03, -0.03
    for force in term.forces:
        f_one = np.zeros_like(f)
        force.kernels(2)[0](q, 0 * q, force.dofs, force.table, f_one)
        f += f_one
    # k (u - gap) on either side.
    np.testing.assert_allclose(f[dof], [2000.0, -1000.0], rtol=1e-12)
    assert (term.mass - alone.mass).diagonal().sum() == pytest.approx(6.0, rel=1e-12)
    carried = term.carried - alone.carried
    np.testing.assert_allclose(carried.sum(axis=0), [3.0, 3.0], rtol=1e-9)
    springs = [{**at, "linear": 10.0}, {**at, "linear": 20.0}]
    one, both = (
        effects.assemble(made, {**LINEAR, "cubic_spring": each})
        for each in ({**at, "linear": 30.0}, springs)
    )
    assert abs(one.stiffness - both.stiffness).max() <= 1e-15 * abs(one.stiffness).max()
