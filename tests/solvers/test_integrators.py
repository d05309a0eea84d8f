"""What every integrator passes, of the full order and of reduced models alike: a file of `schemes`
or of `steppers` is found by listing its folder and tested without a word here.

    m u'' + c u' + k u + k_3 u^3 = 0,    two displacements at most

The tests of `test_schemes` are about bodies, those of `test_gauss` and `test_dop853` about orders.
"""

from dataclasses import dataclass, field
from importlib import import_module
from pkgutil import iter_modules
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.sparse import csr_matrix
from scipy.special import ellipj, ellipk
from vector_fields import polynomial, solve

from vibrom import effects
from vibrom.solvers.full import schemes
from vibrom.solvers.full.newmark import Newmark, Record
from vibrom.solvers.reduced import steppers
from vibrom.solvers.reduced.functions import field_of
from vibrom.term import Term

RESIDUAL = 1e-11  # of a step, of the full order; rtol of reduced models


@dataclass(frozen=True)
class System:
    """Displacements of unit mass that are coupled by their stiffness."""

    stiffness: np.ndarray = field(default_factory=lambda: np.ones((1, 1)))  # k
    cubic: float = 0.0  # k_3, of the first displacement
    stop: tuple[float, float] | None = None  # its gap and stiffness, of the first displacement

    @property
    def size(self) -> int:
        """Displacements."""
        return len(self.stiffness)

    def term(self) -> Term:
        """As the full order knows it, with the forces of the effects."""
        n, none = self.size, Term()
        made = Term(mass=csr_matrix(np.eye(n)), stiffness=csr_matrix(self.stiffness))
        first = SimpleNamespace(size=n, dof=lambda *where: 0)
        where = {"at": [0.0, 0.0], "direction": "x"}
        if self.cubic:
            spring = effects.load("cubic_spring", {**where, "cubic": self.cubic})
            made = made + spring.assemble(first, none)
        if self.stop:
            gap, stiffness = self.stop
            settings = {**where, "gap": gap, "stiffness": stiffness}
            made = made + effects.load("stop", settings).assemble(first, none)
        return made

    def drift(self, y: np.ndarray) -> np.ndarray:
        """As a reduced model knows it: dy/dt (runs, 2n) of y = (u, v)."""
        u, v = np.split(y, 2, axis=1)
        rate = -u @ self.stiffness
        rate[:, 0] -= self.cubic * u[:, 0] ** 3
        if self.stop:
            rate[:, 0] -= self.stop[1] * np.maximum(u[:, 0] - self.stop[0], 0.0)
        return np.concatenate([v, rate], axis=1)


def of_full_order(scheme: str):
    """The states (m, 2n) at every n-th step; None where a step fails."""
    settings = Newmark(scheme=scheme, tolerance=RESIDUAL)

    def run(system: System, u, v, step, count, every=1, scale=1.0):
        start, speed = (np.array(part, float)[:, None] for part in (u, v))
        motion = settings.run(
            system.term(), start, np.array([step]), count, velocity=speed, record=Record(every)
        )
        if motion.outcomes != ["ok"]:
            return None
        return np.concatenate([motion.displacement[0], motion.velocity[0]], axis=1)

    return run


def of_reduced_model(name: str):
    """Likewise; a method with steps of its own takes those that its tolerance allows."""
    module = import_module(f"{steppers.__name__}.{name}")

    def run(system: System, u, v, step, count, every=1, scale=1.0):
        start = np.concatenate([u, v]).astype(float)[None]
        times = step * np.arange(0, count + 1, every, dtype=float)[None]
        steps = int(np.ceil(2 * np.pi * scale / step - 1e-6))
        length = max(np.abs(u).max(), scale * np.abs(v).max())
        size = np.repeat([length, length / scale], system.size)
        given = {"rtol": RESIDUAL, "atol": 1e-3 * RESIDUAL * size}
        given |= {"reach": 1e3 * size, "limit": 1e6 * size}
        stepper = module.stepper(scale, steps)
        if system.size == 1 and system.stop is None:
            k = system.stiffness[0, 0]
            compiled = polynomial({(0, 1): 1.0}, {(1, 0): -k, (3, 0): -system.cubic})
            found = solve(stepper, compiled, start, times, **given)
        else:
            with field_of(2 * system.size, system.drift) as made:
                found = solve(stepper, made, start, times, **given)
        return found.samples[0] if found.outcome == ["ok"] else None

    return run


SCHEMES = {item.name: of_full_order(item.name) for item in iter_modules(schemes.__path__)}
STEPPERS = {item.name: of_reduced_model(item.name) for item in iter_modules(steppers.__path__)}
every = pytest.mark.parametrize("name", [*SCHEMES, *STEPPERS])
RUN = SCHEMES | STEPPERS

DUFFING = System(cubic=1.0)
MODULUS = 0.5 / 2.0  # m of the elliptic functions: k_3 A^2/(2 (k + k_3 A^2)), A = 1
PERIOD = 4 * ellipk(MODULUS) / np.sqrt(2.0)


def swing(t):
    """u and v of DUFFING from u = 1 at rest:  u = cn(sqrt(2) t | 1/4)."""
    sn, cn, dn, _ = ellipj(np.sqrt(2.0) * t, MODULUS)
    return np.stack([cn, -np.sqrt(2.0) * sn * dn], axis=-1)


def energy(states):
    """Of DUFFING; 3/4 at the start."""
    u, v = states.T
    return v**2 / 2 + u**2 / 2 + u**4 / 4


@every
def test_its_error_falls_with_the_step_at_least_as_a_square(name):
    """Against the closed form; what is as good as the tolerance cannot become better."""
    errors = []
    for count in (50, 100, 200):
        states = RUN[name](DUFFING, [1.0], [0.0], PERIOD / count, 3 * count)
        exact = swing(PERIOD / count * np.arange(3 * count + 1))
        errors.append(np.abs(states - exact).max())
    # Global errors are some steps times those of a step.
    floor = 600 * RESIDUAL
    for before, after in zip(errors, errors[1:]):
        assert after < floor or np.log2(before / after) > 1.9
    if name in SCHEMES:
        assert np.log2(errors[1] / errors[2]) == pytest.approx(2.0, abs=0.1)


@every
def test_its_energy_does_not_drift_in_a_hundred_thousand_periods(name):
    """That of a symmetric method swings, and swings no farther at the end than at the start; others
    lose no more than their tolerance a step. Twenty steps a period.
    """
    periods, sampled = 100_000, 500
    states = RUN[name](DUFFING, [1.0], [0.0], PERIOD / 8, 8 * periods, every=8 * sampled + 1)
    first = RUN[name](DUFFING, [1.0], [0.0], PERIOD / 8, 2000)
    error, at_first = (np.abs(energy(part) / 0.75 - 1.0) for part in (states, first))
    steps = 8 * periods
    assert error.max() < 1.05 * at_first.max() + RESIDUAL * steps


@every
def test_what_is_too_stiff_for_its_steps_is_right_or_refused(name):
    """The second spring is 1e12 times stiffer, and no step resolves it; it follows the first."""
    stiff = np.array([[1.0, -0.5], [-0.5, 1e12]])
    states = RUN[name](System(stiff), [1.0, 0.5e-12], [0.0, 0.0], 2 * np.pi / 200, 400)
    if states is None:
        assert name in STEPPERS  # an explicit one says that its steps would be too short
        return
    # The period is wrong by (w h)^2/12 at most, 1e-3 over two periods; the other displacement is
    # half of the first, in units of 1e-12, and oscillates about that by as much as it begins off.
    t = 2 * np.pi / 200 * np.arange(401)
    assert np.abs(states[:, 0] - np.cos(t)).max() < 2e-3
    assert np.abs(states[:, 1]).max() < 1e-12


@every
def test_a_stop_is_met_at_the_right_time(name):
    """A closed form of pieces; the period is twice the flight from -1 to the gap and the time in
    contact. Contacts begin and end within steps.
    """
    gap, stiffness = 0.3, 50.0
    speed, stiff = np.sqrt(1 - gap**2), np.sqrt(1 + stiffness)
    ahead = gap - stiffness * gap / stiff**2
    period = 2 * (np.pi - np.arccos(gap)) + 2 * np.arctan2(speed / stiff, ahead) / stiff
    system, errors, lost = System(stop=(gap, stiffness)), [], []
    for count in (200, 800):
        states = RUN[name](system, [-1.0], [0.0], period / count, 5 * count)
        errors.append(np.abs(states[::count] - [-1.0, 0.0]).max())
        u, v = states.T
        kept = v**2 + u**2 + stiffness * np.maximum(u - gap, 0.0) ** 2
        lost.append(np.abs(kept - 1.0).max())
    # Of second order within a contact, of first where one begins or ends within a step: the finer
    # steps make either at least three times better.
    assert errors[0] < 0.1 and errors[1] < errors[0] / 3 + 1e-4
    assert lost[0] < 0.03 and lost[1] < lost[0] / 3 + 1e-6


@every
def test_what_nothing_holds_moves_on(name):
    """A second displacement without stiffness: u = v t, to rounding; the first one swings."""
    free = np.diag([1.0, 0.0])
    states = RUN[name](System(free), [1.0, 0.0], [0.0, 3.0], 0.05, 400)
    t = 0.05 * np.arange(401)
    assert np.abs(states[:, 1] - 3.0 * t).max() < 1e-11 * 60
    assert np.abs(states[:, 0] - np.cos(t)).max() < 0.05**2 / 24 * 20 * 2.1


@every
@pytest.mark.parametrize("length, time", [(2.0**-60, 2.0**40), (2.0**60, 2.0**-40)])
def test_units_do_not_matter(name, length, time):
    """Lengths of 1e-18 and 1e18, times of 1e12 and 1e-12."""
    scaled = System(np.full((1, 1), time**-2), time**-2 * length**-2)
    here = RUN[name](DUFFING, [1.0], [0.0], PERIOD / 40, 400)
    there = RUN[name](scaled, [length], [0.0], time * PERIOD / 40, 400, scale=time)
    assert np.abs(there / [length, length / time] - here).max() < 100 * 400 * RESIDUAL


@every
def test_time_runs_back_to_the_start(name):
    """Without numerical damping; forty steps a period alone would be wrong by a hundredth."""
    there = RUN[name](DUFFING, [1.0], [0.3], PERIOD / 40, 400)[-1]
    back = RUN[name](DUFFING, there[:1], -there[1:], PERIOD / 40, 400)[-1]
    assert np.abs(back - [1.0, -0.3]).max() < 100 * 800 * RESIDUAL
