"""Bodies under every scheme of time integration, found by listing the folder: rotations, numerical
damping, batches, sparse tangents; and what an energy-momentum scheme is for.
"""

from importlib import import_module
from pkgutil import iter_modules

import numpy as np
import pytest
from scenes import body
from scipy.sparse import csr_matrix

from vibrom import effects
from vibrom.bodies import space
from vibrom.models.energy import energy
from vibrom.solvers.full import schemes
from vibrom.solvers.full.newmark import Newmark, Record
from vibrom.term import SceneError, Term

NAMES = [item.name for item in iter_modules(schemes.__path__)]
MODULES = {name: import_module(f"{schemes.__name__}.{name}") for name in NAMES}
DAMPED = [name for name in NAMES if getattr(MODULES[name], "DAMPED", True)]
CONSERVING = [name for name in NAMES if MODULES[name].scheme(0.0).mean]
SOFT = {"young_modulus": 1e6, "poisson_ratio": 0.3, "plane": "stress"}
FREE = {
    "inertia": {"density": 440.0},
    "elasticity": SOFT,
    "geometric_nonlinearity": {},
}
SPIN = 20.0  # rad/s
TURN = 2 * np.pi / SPIN  # s


class Free:
    """A soft body that nothing holds, spinning and stretched as it starts."""

    def __init__(self):
        self.made = space.build(body(cells=[1, 1], height=0.5, clamped=[]))
        self.term = effects.assemble(self.made, FREE)
        self.n = self.made.size
        place, axis = self.made.dof_location, self.made.dof_axis
        self.x, self.y = (np.flatnonzero(axis == along) for along in (0, 1))
        np.testing.assert_array_equal(place[self.x], place[self.y])  # node by node
        self.place = np.where(axis == 0, place[:, 0], place[:, 1])
        off = self.place - np.where(axis == 0, 0.5, 0.25)
        rng = np.random.default_rng(0)
        # Its centre rests, but for a stretch that any draw may have.
        self.velocity = SPIN * self.turned(off, np.pi / 2) + rng.standard_normal(self.n)
        for part in (self.x, self.y):
            drift = np.zeros(self.n)
            drift[part] = 1.0
            self.velocity -= drift * (drift @ self.momentum) / (drift @ (self.term.mass @ drift))

    @property
    def momentum(self):
        """M v (n,)."""
        return self.term.mass @ self.velocity

    def turned(self, vectors, angle):
        """Vectors (..., n) of all nodes, turned."""
        out = np.empty_like(vectors)
        x, y = vectors[..., self.x], vectors[..., self.y]
        out[..., self.x] = np.cos(angle) * x - np.sin(angle) * y
        out[..., self.y] = np.sin(angle) * x + np.cos(angle) * y
        return out

    def run(self, start, velocity, step, steps, every, **settings):
        """Displacements and velocities (m, n)."""
        motion = Newmark(**settings).run(
            self.term,
            start[:, None],
            np.array([step]),
            steps,
            velocity=velocity[:, None],
            record=Record(every),
        )
        assert motion.outcomes == ["ok"]
        return motion.displacement[0], motion.velocity[0]

    def moment(self, q, v):
        """Angular momentum (m,) about the origin."""
        p, place = (self.term.mass @ v.T).T, self.place + q
        return np.sum(place[:, self.x] * p[:, self.y] - place[:, self.y] * p[:, self.x], axis=1)


@pytest.fixture(scope="module")
def free():
    return Free()


@pytest.mark.parametrize("name", CONSERVING)
def test_a_free_body_keeps_energy_and_angular_momentum_for_a_hundred_thousand_steps(name, free):
    """Thirty steps a turn, which do not resolve its own oscillations. What a step leaves open is a
    residual of 1e-13; its sign changes from step to step.
    """
    start = np.zeros(free.n)
    q, v = free.run(start, free.velocity, TURN / 30, 100_000, 500, scheme=name, tolerance=1e-13)
    kept, spin = energy(free.term, q, v, start), free.moment(q, v)
    assert np.abs(kept / kept[0] - 1).max() < 1e-9
    assert np.abs(spin / spin[0] - 1).max() < 1e-9


def test_others_do_not(free):
    """The same steps: Newmark's method stops, or gains and loses energy."""
    motion = Newmark(tolerance=1e-10).run(
        free.term,
        np.zeros((free.n, 1)),
        np.array([TURN / 30]),
        1000,
        velocity=free.velocity[:, None],
    )
    kept = energy(free.term, motion.displacement[0], motion.velocity[0], np.zeros(free.n))
    assert motion.outcomes != ["ok"] or np.abs(kept / kept[0] - 1).max() > 1e-3


@pytest.mark.parametrize("name", NAMES)
def test_a_turned_start_makes_a_turned_motion(name, free):
    """Objectivity: the same steps, turned by an angle, about the origin."""
    angle, settings = 2.1, {"scheme": name, "tolerance": 1e-11}
    q, v = free.run(np.zeros(free.n), free.velocity, TURN / 400, 200, 10, **settings)
    turned = free.turned(free.place, angle) - free.place
    start = turned + free.turned(np.zeros(free.n), angle)
    speed = free.turned(free.velocity, angle)
    there, faster = free.run(start, speed, TURN / 400, 200, 10, **settings)
    assert np.abs(there - turned - free.turned(q, angle)).max() < 1e-8
    assert np.abs(faster - free.turned(v, angle)).max() < 1e-8 * SPIN


def oscillator(square):
    """u'' + square u = 0."""
    return Term(mass=csr_matrix([[1.0]]), stiffness=csr_matrix([[square]]))


@pytest.mark.parametrize("alpha", [0.0, 0.05, 0.4])
@pytest.mark.parametrize("name", DAMPED)
def test_numerical_damping_of_what_no_step_resolves(name, alpha):
    """(1 - alpha)/(1 + alpha) a step. Its root is double or more: x_n = (c + d n + e n^2) rho^n
    once the transient is over, whose third differences over rho^n vanish.
    """
    motion = Newmark(scheme=name, alpha=alpha).run(
        oscillator(1e8), np.ones((1, 1)), np.array([1.0]), 40
    )
    x, rho = motion.displacement[0, :, 0], (1 - alpha) / (1 + alpha)
    scaled = x / (-rho) ** np.arange(41)
    assert np.abs(np.diff(scaled[3:], 3)).max() < 1e-3 * np.abs(scaled).max()
    assert np.abs(scaled[3:]).min() > 1e-3


@pytest.mark.parametrize("name", DAMPED)
def test_numerical_damping_of_what_steps_resolve(name):
    """Newmark's method loses alpha w h/2 a radian, which is of first order; the generalised-alpha
    method only what is of third.
    """
    ratios = []
    for count in (50, 100):
        step = 2 * np.pi / count
        motion = Newmark(scheme=name, alpha=0.1).run(
            oscillator(1.0), np.ones((1, 1)), np.array([step]), 10 * count
        )
        q, v = motion.displacement[0, :, 0], motion.velocity[0, :, 0]
        ratios.append(-np.log((q[-1] ** 2 + v[-1] ** 2) / (q[0] ** 2 + v[0] ** 2)) / (40 * np.pi))
    order = np.log2(ratios[0] / ratios[1])
    if name == "newmark":
        assert ratios[1] == pytest.approx(0.1 * 2 * np.pi / 100 / 2, rel=0.01)
    else:
        assert order == pytest.approx(3.0, abs=0.2)


def test_energy_momentum_has_no_numerical_damping():
    with pytest.raises(SceneError, match=r"alpha = 0.1 damps.*choose alpha = 0, or scheme"):
        Newmark(scheme="energy_momentum", alpha=0.1).parameters()


@pytest.mark.parametrize("name", NAMES)
def test_states_side_by_side_and_sparse_tangents(name, free):
    """Nine states in a batch of sixteen, four in one of eight, one alone, and in a sparse matrix;
    each under a load of its own.
    """
    load = np.zeros(free.n)
    load[free.y[-1]] = 1.0
    term, states, steps = free.term + Term(load=load), 13, 40
    signal = np.sin(np.arange(steps + 1) / 5)[:, None] * np.linspace(0, 300, states)
    start, step = np.zeros((free.n, states)), np.full(states, TURN / 200)
    velocity = np.repeat(free.velocity[:, None], states, axis=1)
    settings = Newmark(scheme=name, tolerance=1e-10)
    together = settings.run(term, start, step, steps, velocity=velocity, signal=signal)
    assert together.outcomes == ["ok"] * states
    for index in (0, 5, 12):
        one = slice(index, index + 1)
        for widest in (500, 0):
            alone = Newmark(scheme=name, tolerance=1e-10, widest_band=widest).run(
                term,
                start[:, one],
                step[one],
                steps,
                velocity=velocity[:, one],
                signal=signal[:, one],
            )
            apart = np.abs(together.displacement[index] - alone.displacement[0]).max()
            assert apart < 1e-7 * np.abs(alone.displacement).max()


@pytest.mark.parametrize("name", NAMES)
def test_a_linear_body_moves_as_without_the_shortcut(name, free):
    """Steps in displacements with one factor, against Newton's steps of a force that is zero."""
    linear = effects.assemble(free.made, {k: FREE[k] for k in ("inertia", "elasticity")})
    stop = {"at": [1.0, 0.5], "direction": "y", "gap": 1e9, "stiffness": 1.0}
    same = effects.assemble(
        free.made, {**{k: FREE[k] for k in ("inertia", "elasticity")}, "stop": stop}
    )
    given = {"velocity": free.velocity[:, None]}
    ends = [
        Newmark(scheme=name, tolerance=1e-12).run(
            term, np.zeros((free.n, 1)), np.array([TURN / 200]), 100, **given
        )
        for term in (linear, same)
    ]
    for part in ("displacement", "velocity", "acceleration"):
        one, other = (getattr(end, part)[0] for end in ends)
        assert np.abs(one - other).max() < 1e-7 * np.abs(other).max()
