"""Least damping and turning against closed forms."""

from dataclasses import replace

import numpy as np
import pytest
import two_dofs
from oscillators import DAMPING, OMEGA, linear_rom

from vibrom.latent.polynomial import exponents
from vibrom.studies.parts.certificate import least

ZETA = DAMPING / (2 * OMEGA)


def rom(**terms):
    """z'' / OMEGA^2 = -z - 2 ZETA v + terms, v = z' / OMEGA; `z3` is the coefficient of z^3."""
    powers = exponents(2, 1, 3)
    row = np.zeros(len(powers))
    known = {(1, 0): -1.0, (0, 1): -2 * ZETA}
    named = {"z3": (3, 0), "z2v": (2, 1), "v3": (0, 3), "zv2": (1, 2)}
    for power, value in {**known, **{named[name]: value for name, value in terms.items()}}.items():
        row[(powers == power).all(axis=1)] += value * OMEGA**2
    kinematic = np.where((powers == [0, 1]).all(axis=1), OMEGA, 0.0)
    return replace(linear_rom(), dynamics=np.stack([kinematic, row]), dynamics_powers=powers)


def test_a_linear_oscillator_has_its_damping_ratio():
    damping, turning = least(rom())
    assert damping == pytest.approx(ZETA, rel=1e-9) and turning == pytest.approx(1.0, rel=1e-12)


def test_what_is_damped_at_rest_and_fed_farther_out_is_found():
    """-o/(2 v) = ZETA - b z^2/2 with z up to 10, on the grid to its last angle."""
    damping, _ = least(rom(z2v=0.001))
    last = np.cos(0.5 * np.pi / 361) ** 2
    assert damping == pytest.approx(ZETA - 0.001 * 100 * last / 2, rel=1e-6) and damping < 0
    assert least(rom(z2v=-0.001))[0] == pytest.approx(ZETA, abs=1e-6)


def test_a_softening_spring_turns_back_where_it_gives_way():
    """(v^2 - z e)/(z^2 + v^2) along z is 1 - a z^2, and that is least where z = 10."""
    _, turning = least(rom(z3=0.02))
    assert turning == pytest.approx(1 - 0.02 * 100, rel=1e-3)
    assert least(rom(z3=-0.02))[1] == pytest.approx(1.0, abs=1e-6)


def test_several_oscillators_are_not_judged():
    assert np.isnan(least(two_dofs.rom())).all()
