"""Corrections that were put into a motion are found in it."""

import numpy as np
import pytest
from scenes import THESIS, body
from scipy.integrate import solve_ivp

from vibrom import effects
from vibrom.bodies import space
from vibrom.methods.equations import Equations
from vibrom.methods.equations_corrected import EquationsCorrected
from vibrom.models.measures import nmte_percent
from vibrom.models.rollout import Integrator, rollout
from vibrom.models.training import MethodError, Training, Trajectory

TRUE = np.array([-2.0 + 8.0j, 10.0 - 200.0j])  # 1/s, and 1/s over x


@pytest.fixture(scope="module")
def start():
    term = effects.assemble(space.build(body(cells=[10, 1])), THESIS)
    return Equations(order=7).learn(Training((), term=term))


@pytest.fixture(scope="module")
def motion(start):
    """Of z' = z [g(x) + TRUE_0 + TRUE_1 x], in the coordinates u and w = pole z + conj."""
    steps = 1e-6 * start.reach
    values = np.linalg.eigvals((start.drift(np.diag(steps)) / steps[:, None]).T)
    pole = values[values.imag.argmax()]

    def slope(time, real):
        z = (real[1] - pole.conj() * real[0]) / (pole - pole.conj())
        more = z * (TRUE[0] + TRUE[1] * abs(z) ** 2)
        return start.drift(real) + 2.0 * np.array([more.real, (pole * more).real])

    time = np.linspace(0.0, 12 * 2 * np.pi / pole.imag, 12 * 200 + 1)
    begin = start.reach * [0.6, 0.0]
    close = {"method": "DOP853", "rtol": 1e-9, "atol": 1e-9}
    solved = solve_ivp(slope, time[[0, -1]], begin, t_eval=time, **close)
    q, v = np.split(start.decode(solved.y.T), 2, axis=1)
    return Trajectory(time, q, v, 0.0 * q)


def test_what_was_added_is_found(start, motion):
    before = rollout(start, start.encode(motion.state[:1]), motion.time[None], Integrator())
    rom = EquationsCorrected().learn(Training((motion,), start=start))
    after = rollout(rom, rom.encode(motion.state[:1]), motion.time[None], Integrator())
    errors = [
        nmte_percent(motion.displacement, model.displacement(run.reduced[0]))
        for model, run in ((start, before), (rom, after))
    ]
    # Trapezoids over steps of 2 pi/200: relative errors of (2 pi/200)^2/12 = 1e-4 of what is found.
    assert errors[0] > 5.0 and errors[1] < 1e-3 * errors[0]
    np.testing.assert_allclose(rom.reach, np.abs(after.reduced[0]).max(axis=0), rtol=1e-3)


def test_it_says_what_it_starts_from(motion):
    with pytest.raises(MethodError, match="starts_from: equations"):
        EquationsCorrected().learn(Training((motion,)))


def test_a_correction_of_too_high_a_degree_is_refused(start, motion):
    with pytest.raises(MethodError, match="lower order"):
        EquationsCorrected(order=6).learn(Training((motion,), start=start))
