"""Couples against beam theory, dry friction against Coulomb's law."""

import numpy as np
import pytest
from scenes import BEAM, BENDING, body, quadratic_body

from vibrom import effects
from vibrom.bodies import space
from vibrom.solvers.full import static
from vibrom.solvers.full.modes import eigenmodes
from vibrom.solvers.full.newmark import Newmark, Record
from vibrom.term import SceneError

TIP = {"at": [1.0, 0.01], "direction": "y"}


def test_an_end_moment_bends_a_beam_into_a_parabola_and_then_into_a_circle():
    """w = M L^2/(2 EI) while small; under M = EI/L the angle of the end is one radian."""
    made = space.build(quadratic_body(cells=[20, 1], probes={"tip": TIP}))
    linear = effects.assemble(made, {**BEAM, "couple": {"edge": "right"}})
    q = static.equilibrium(linear, 1.0)
    assert q[made.probes["tip"]] == pytest.approx(1.0 / (2 * BENDING), rel=1e-3)
    at, axis = made.dof_location, made.dof_axis
    # No resultant, and a moment of one: virtual work of rigid translations and of a rotation.
    for direction in (0, 1):
        assert linear.load @ (axis == direction) == pytest.approx(0.0, abs=1e-12)
    turn = np.where(axis == 0, -(at[:, 1] - 0.01), at[:, 0] - 1.0)
    assert linear.load @ turn == pytest.approx(1.0, rel=1e-12)
    # Forces of fixed direction turn the end by less the more it turns: M cos(angle) acts.
    bent = {**BEAM, "geometric_nonlinearity": {}, "couple": {"edge": "right"}}
    bent = effects.assemble(made, bent)
    q, moment = static.equilibrium(bent, 0.5 * BENDING), 0.5
    angle = 0.0
    for _ in range(100):
        angle = moment * np.cos(angle)
    expected = (1 - np.cos(angle)) / angle  # of an arc of unit length
    assert q[made.probes["tip"]] == pytest.approx(expected, rel=2e-3)


def test_couples_in_space_are_about_each_axis():
    block = {"shape": "block", "element": "serendipity", "cells": [3, 1, 1]}
    made = space.build(body(**block))
    middle = np.array([1.0, 0.01, 0.025])
    for axis, about in enumerate("xyz"):
        load = effects.assemble(made, {**BEAM, "couple": {"edge": "right", "about": about}}).load
        forces = np.zeros((made.size, 3))
        forces[np.arange(made.size), made.dof_axis] = load
        moment = np.cross(made.dof_location - middle, forces).sum(axis=0)
        np.testing.assert_allclose(moment, np.eye(3)[axis], atol=1e-12)
        np.testing.assert_allclose(forces.sum(axis=0), 0.0, atol=1e-11)


def test_what_cannot_be_turned_is_refused():
    made = space.build(quadratic_body(cells=[2, 1]))
    for settings, says in (
        ({"edge": "left"}, "effects.couple.edge = 'left' is clamped"),
        ({"edge": "rigth"}, "did you mean 'right'"),
        ({"edge": "right", "about": "x"}, "would turn a plane body out of its plane"),
    ):
        with pytest.raises(SceneError, match=says):
            effects.assemble(made, {**BEAM, "couple": settings})


def test_dry_friction_takes_the_same_from_every_swing():
    """Coulomb: the amplitude of an oscillator falls by 4 F/k a period, in a straight line, and it
    sticks where the spring cannot overcome F. A heavy mass at the tip makes the beam one.
    """
    made = space.build(quadratic_body(cells=[2, 1], probes={"tip": TIP}))
    heavy = {**BEAM, "tip_mass": {"at": TIP["at"], "mass": 1000.0}}
    bare = effects.assemble(made, heavy)
    mode, dof = eigenmodes(bare, 1), made.probes["tip"]
    shape = mode.shape[0] / mode.shape[0][dof]
    stiffness = shape @ bare.stiffness @ shape
    omega, start = mode.frequency[0], 0.01
    friction = {"force": stiffness * start / 40, "velocity": 1e-4 * omega * start}
    term = effects.assemble(made, {**heavy, "dry_friction": {**TIP, **friction}})
    steps, periods = 2000, 12
    motion = Newmark().run(
        term,
        start * shape[:, None],
        np.array([2 * np.pi / omega / steps]),
        steps * periods,
        record=Record(every=steps * periods, probes=np.array([dof])),
    )
    assert motion.outcomes == ["ok"]
    tip = motion.probes[0, 0]
    peaks = np.array([tip[k * steps - 20 : k * steps + 20].max() for k in range(1, 9)])
    # F/k is a fortieth of the amplitude, and ten periods take it all.
    np.testing.assert_allclose(peaks / start, 1 - np.arange(1, 9) / 10, atol=2e-3)
    rest = tip[11 * steps :]
    assert np.abs(rest).max() <= 1.01 * start / 40  # it sticks, and creeps
    assert np.ptp(rest) <= 1e-3 * start
