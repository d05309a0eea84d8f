"""Newmark: order two, energy, linear closed form, batch equals loop, sparse equals banded, failures
reported.
"""

import os
import subprocess
import sys

import numpy as np
import pytest
from numba import njit
from scenes import CANTILEVER, LINEAR, THESIS, UNDAMPED, body

from vibrom import effects
from vibrom.artefacts.outcome import Outcome
from vibrom.bodies import space
from vibrom.kernels.lanes import get, put
from vibrom.solvers.full.modes import eigenmodes
from vibrom.solvers.full.newmark import Newmark, Record
from vibrom.solvers.full.scheme import extrapolated, predicted, weights
from vibrom.solvers.full.schemes import newmark
from vibrom.solvers.full.static import equilibrium
from vibrom.term import SceneError


@pytest.fixture(scope="module")
def cantilever():
    made = space.build(CANTILEVER)
    return made, effects.assemble(made, THESIS)


@pytest.fixture(scope="module")
def undamped():
    made = space.build(body(cells=[4, 1], height=0.2))
    return made, effects.assemble(made, UNDAMPED)


def test_linear_decay_is_that_of_the_damped_mode():
    """q = phi e^{-zeta omega t} (cos omega_d t + zeta/sqrt(1-zeta^2) sin omega_d t), up to the
    method's second order.
    """
    made = space.build(CANTILEVER)
    term = effects.assemble(made, {**LINEAR, "rayleigh_damping": {"damping_ratio": 0.01}})
    (omega,), (phi,) = (part[:1] for part in eigenmodes(term, 1))
    damped, steps = omega * np.sqrt(1 - 1e-4), 2000
    step = 2 * np.pi / damped / 400
    motion = Newmark().run(term, 0.01 * phi[:, None], np.array([step]), steps)
    t = motion.kept * step
    exact = (
        0.01
        * np.exp(-0.01 * omega * t)
        * (np.cos(damped * t) + 0.01 / np.sqrt(1 - 1e-4) * np.sin(damped * t))
    )
    modal = motion.displacement[0] @ (term.mass @ phi)
    # Period error (omega h)^2/12 = 2e-5 a radian, over 5 periods 31 rad: 6.5e-4 of the amplitude.
    assert np.abs(modal - exact).max() <= 0.01 * 1.05 * (omega * step) ** 2 / 12 * damped * t[-1]


SCHEME = newmark.scheme(0.01)


@njit
def of_lanes(q, v, a, past, h, ends):
    """The formulas on registers of two states, as a compiled step evaluates them."""
    plain = predicted(SCHEME, get(h, 0, 2), get(q, 0, 2), get(v, 0, 2), get(a, 0, 2))
    guess = extrapolated(
        get(a, 0, 2), get(past, 0, 2), get(past, 1, 2), get(past, 2, 2), get(past, 3, 2)
    )
    for place, value in enumerate((*plain, guess)):
        put(ends, place, value)


def test_formulas_are_the_same_for_arrays_and_for_lanes():
    """A motion of constant acceleration is exact; the guess is exact for a cubic and an
    alternation of sign.
    """
    h = np.array([[0.1, 0.2]])
    t = np.arange(-4.0, 2.0)[:, None] * h
    a = 1.0 + 2.0 * t - 3.0 * t**2 + 5.0 * t**3 + 0.7 * (-1.0) ** np.arange(6)[:, None]
    q, v, past = np.full((1, 2), 0.3), np.full((1, 2), -0.4), a[3::-1].copy()
    by_q, by_v = weights(SCHEME, h)
    plain_q, plain_v = predicted(SCHEME, h, q, v, a[4:5])
    np.testing.assert_allclose(plain_q + by_q * a[4:5], q + h * v + h**2 / 2 * a[4:5], rtol=1e-14)
    np.testing.assert_allclose(plain_v + by_v * a[4:5], v + h * a[4:5], rtol=1e-14)
    guess = extrapolated(a[4:5], *past[:, None])
    np.testing.assert_allclose(guess, a[5:6], rtol=1e-12)
    ends = np.zeros((3, 2))
    of_lanes(q, v, a[4:5].copy(), past, h, ends)
    np.testing.assert_allclose(ends, np.concatenate([plain_q, plain_v, guess]), rtol=1e-14)


def test_order_two(undamped):
    """The steps resolve even the fastest mode, which the release excites: only then is the error
    that of the leading order.
    """
    made, term = undamped
    (omega,), (phi,) = (part[:1] for part in eigenmodes(term, 1))
    start = (0.2 / np.abs(phi).max() * phi)[:, None]
    period, ends = 2 * np.pi / omega, []
    counts = [4000, 8000, 16000, 32000]
    for count in counts:
        motion = Newmark(tolerance=1e-10).run(
            term, start, np.array([0.25 * period / count]), count, record=Record(every=count)
        )
        assert motion.outcomes == ["ok"]
        ends.append(phi @ (term.mass @ motion.displacement[0, -1]))
    # Three halvings give two ratios of successive differences, each 2^order.
    orders = np.log2(np.abs(np.diff(ends))[:-1] / np.abs(np.diff(ends))[1:])
    np.testing.assert_allclose(orders, 2.0, atol=0.1)


def test_energy_of_an_undamped_motion_stays(undamped):
    """Trapezoidal rule: energy is not conserved exactly by a nonlinear body, but its error is of
    second order and does not drift away.
    """
    made, term = undamped
    (omega,), (phi,) = (part[:1] for part in eigenmodes(term, 1))
    start = (0.05 / np.abs(phi).max() * phi)[:, None]
    errors = []
    for count in (4000, 8000):
        motion = Newmark(tolerance=1e-10).run(
            term,
            start,
            np.array([2 * np.pi / omega / count]),
            3 * count,
            record=Record(every=count // 50),
        )
        energy = np.array(
            [
                0.5 * v @ (term.mass @ v) + strain_energy(made, term, q)
                for q, v in zip(motion.displacement[0], motion.velocity[0])
            ]
        )
        errors.append(np.abs(energy / energy[0] - 1).max())
    assert errors[1] < 1e-4 and errors[1] == pytest.approx(errors[0] / 4, rel=0.2)


def test_energy_of_the_folding_beam(cantilever):
    """The thesis's beam, released undamped from the shape in which it folds: what gamma = 1/2 and
    the thesis's alpha do to its energy.
    """
    made, term = cantilever
    free, step = effects.assemble(made, UNDAMPED), 2 * np.pi / 398.0325
    signal = 3000 * np.sin(2 * np.pi * np.arange(13377) / 1000)[:, None]
    shape = Newmark(alpha=0.005).run(
        term,
        np.zeros((made.size, 1)),
        np.array([step / 1000]),
        13376,
        signal=signal,
        record=Record(start=13376),
    )
    drift = {}
    for alpha, count in ((0.0, 500), (0.0, 1000), (0.005, 1000)):
        motion = Newmark(alpha=alpha, tolerance=1e-7).run(
            free,
            shape.displacement[0].T,
            np.array([step / count]),
            30 * count,
            record=Record(every=count // 10),
        )
        energy = np.array(
            [
                0.5 * v @ (free.mass @ v) + strain_energy(made, free, q)
                for q, v in zip(motion.displacement[0], motion.velocity[0])
            ]
        )
        drift[alpha, count] = energy[-1] / energy[0] - 1, np.abs(energy / energy[0] - 1).max()
    # Second order without numerical damping: four times less for half the step; with it, energy can
    # only fall.
    assert (
        drift[0.0, 1000][1] == pytest.approx(drift[0.0, 500][1] / 4, rel=0.1)
        and drift[0.0, 1000][1] < 1e-4
    )
    assert -0.05 < drift[0.005, 1000][0] < 0


def strain_energy(made, term, u):
    """W = int_0^1 u . f(s u) ds exactly: f is a cubic in s, so two Gauss points do."""
    force, points = term.forces[0], 0.5 + np.array([-0.5, 0.5]) / np.sqrt(3)
    total = 0.0
    for s in points:
        f = np.zeros((made.size, 1))
        force.kernels(1)[0](s * u[:, None], np.zeros((made.size, 1)), force.dofs, force.table, f)
        total += 0.5 * u @ (term.stiffness @ (s * u) + f[:, 0])
    return total


def test_batch_equals_loop(cantilever):
    """Thirteen states go in a batch of sixteen, four in one of eight."""
    made, term = cantilever
    steps, forcing = 1000, np.array([1.0, 600.0, 3000.0, 6000.0])
    signal = np.sin(2 * np.pi * np.arange(steps + 1) / 500)[:, None] * forcing
    step, rest = np.full(4, 2 * np.pi / 398.0325 / 500), np.zeros((made.size, 13))
    solver = Newmark(alpha=0.005, tolerance=1e-8)
    many = [0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 2]
    large = solver.run(term, rest, step[many], steps, signal=signal[:, many])
    small = solver.run(term, rest[:, :4], step, steps, signal=signal)
    for index in range(4):
        alone = solver.run(term, rest[:, [index]], step[[index]], steps, signal=signal[:, [index]])
        # All are solved to 1e-8; the tangents that they iterate with differ.
        scale = np.abs(alone.displacement).max()
        for together in (small, large):
            assert (
                np.abs(together.displacement[index] - alone.displacement[0]).max() <= 1e-5 * scale
            )
        for copy in np.nonzero(np.array(many) == index)[0]:
            np.testing.assert_array_equal(large.displacement[copy], large.displacement[index])


@pytest.mark.parametrize("stiffness_factor", [0.0, 1e-5])
def test_sparse_equals_banded(stiffness_factor, cantilever):
    """With damping that is a multiple of the mass, of which the banded loop makes use, and with any
    other.
    """
    made, _ = cantilever
    term = effects.assemble(
        made,
        {
            **THESIS,
            "rayleigh_damping": {"damping_ratio": 0.01, "stiffness_factor": stiffness_factor},
        },
    )
    signal = 3000 * np.sin(2 * np.pi * np.arange(201) / 500)[:, None]
    step, rest = np.array([2 * np.pi / 398.0325 / 500]), np.zeros((made.size, 1))
    banded = Newmark(tolerance=1e-8).run(term, rest, step, 200, signal=signal)
    sparse = Newmark(tolerance=1e-8, widest_band=0).run(term, rest, step, 200, signal=signal)
    assert (
        np.abs(banded.displacement - sparse.displacement).max()
        <= 1e-6 * np.abs(banded.displacement).max()
    )
    assert sparse.outcomes == ["ok"]


@pytest.mark.parametrize("states", [1, 4])
@pytest.mark.parametrize(
    "damping", [{}, {"damping_ratio": 0.01}, {"damping_ratio": 0.01, "stiffness_factor": 1e-5}]
)
def test_linear_steps_in_displacements_are_those_in_accelerations(damping, states, cantilever):
    """Forced, under gravity, from a moving start; each state with a step of its own. The stiffness
    is rounded once more, which moves the first frequency by (omega_n / omega_1)^2 eps, 1e-8."""
    made, _ = cantilever
    term = effects.assemble(
        made,
        {
            **LINEAR,
            **({"rayleigh_damping": damping} if damping else {}),
            "modal_load": {"mode": 1},
            "gravity": {"x": 0.0, "y": -9.81},
        },
    )
    signal = 3000 * np.sin(2 * np.pi * np.arange(301)[:, None] / 250 + np.arange(states))
    steps, rest = (
        2 * np.pi / 398.0325 / np.linspace(250, 1000, states),
        np.zeros((made.size, states)),
    )
    speed = np.outer(made.dof_location[:, 0], np.ones(states))
    motion = Newmark(alpha=0.005).run(term, rest, steps, 300, velocity=speed, signal=signal)
    mass, stiffness = term.mass.toarray(), term.stiffness.toarray()
    drag = np.zeros_like(mass) if term.damping is None else term.damping.toarray()
    gamma, beta = 0.505, 0.25 * 1.005**2
    for w, h in enumerate(steps):
        force = np.outer(signal[:, w], term.load) + term.dead_load
        operator = np.linalg.inv(mass + gamma * h * drag + beta * h**2 * stiffness)
        q, v = rest[:, w], speed[:, w]
        a = np.linalg.solve(mass, force[0] - drag @ v)
        for p in force[1:]:
            q, v = q + h * v + h**2 * (0.5 - beta) * a, v + h * (1 - gamma) * a
            a = operator @ (p - drag @ v - stiffness @ q)
            q, v = q + beta * h**2 * a, v + gamma * h * a
        for ours, theirs, digits in zip(
            (motion.displacement, motion.velocity, motion.acceleration),
            (q, v, a),
            (1e-7, 1e-7, 1e-6),
        ):
            assert np.abs(ours[w, -1] - theirs).max() <= digits * np.abs(theirs).max()


def test_equilibrium_gives_the_initial_acceleration(cantilever):
    made, term = cantilever
    start = np.random.default_rng(0).standard_normal((made.size, 1)) * 1e-3
    motion = Newmark().run(term, start, np.array([1e-5]), 1)
    f = np.zeros((made.size, 1))
    force = term.forces[0]
    force.kernels(1)[0](start, np.zeros_like(start), force.dofs, force.table, f)
    residual = term.mass @ motion.acceleration[0, 0] + term.stiffness @ start[:, 0] + f[:, 0]
    assert np.abs(residual).max() <= 1e-9 * np.abs(f).max()


def test_failed_convergence_has_a_time_and_spoils_no_other(cantilever):
    made, term = cantilever
    # Two steps a period of a load that folds the beam: Newton's method cannot follow it.
    signal = np.stack([np.full(60, 1e-3), np.full(60, 5e7), np.full(60, 1e-3)], axis=1)
    motion = Newmark(max_iterations=8).run(
        term, np.zeros((made.size, 3)), np.full(3, 8e-3), 59, signal=signal
    )
    assert motion.outcomes == ["ok", "no_convergence", "ok"]
    assert 0 < motion.failed_at[1] <= 59 * 8e-3
    failed = round(motion.failed_at[1] / 8e-3)
    assert (
        np.isnan(motion.displacement[1, failed:]).all()
        and np.isfinite(motion.displacement[[0, 2]]).all()
    )


def test_records_what_is_asked(cantilever):
    made, term = cantilever
    signal = 600 * np.sin(2 * np.pi * np.arange(4101) / 1000)[:, None]
    step = np.array([2 * np.pi / 398.0325 / 1000])
    whole = Newmark(alpha=0.005).run(
        term,
        np.zeros((made.size, 1)),
        step,
        4100,
        signal=signal,
        record=Record(probes=np.array([3, 7])),
    )
    part = Newmark(alpha=0.005).run(
        term,
        np.zeros((made.size, 1)),
        step,
        4100,
        signal=signal,
        record=Record(every=7, start=1990, probes=np.array([7]), probe_start=1995),
    )
    np.testing.assert_array_equal(part.displacement[0], whole.displacement[0, 1990::7])
    np.testing.assert_array_equal(part.acceleration[0], whole.acceleration[0, 1990::7])
    np.testing.assert_array_equal(part.probes[0, 0], whole.probes[0, 1, 1995:])
    np.testing.assert_array_equal(whole.probes[0, 0], whole.displacement[0, :, 3])


def test_dead_load_holds_the_body_where_statics_does(cantilever):
    """Released at the equilibrium under gravity, the body stays there; the force of 5e4 m/s^2 bends
    it by a tenth of its length.
    """
    made, _ = cantilever
    term = effects.assemble(made, {**THESIS, "gravity": {"x": 0.0, "y": -5e4}})
    rest = equilibrium(term)
    for settings in (Newmark(tolerance=1e-8), Newmark(tolerance=1e-8, widest_band=0)):
        motion = settings.run(term, rest[:, None], np.array([1.5e-5]), 50)
        assert motion.outcomes == ["ok"]
        # A constant residual r bends the body no farther than r/K: the statics' own tolerance,
        # doubled by the swing.
        assert np.abs(motion.displacement[0] - rest).max() <= 1e-6 * np.abs(rest).max()


def test_a_follower_load_in_the_band_and_in_a_sparse_matrix(cantilever):
    """The band keeps half of its tangent, the sparse factorisation all of it: the same motion, in
    as many iterations.
    """
    made, _ = cantilever
    term = effects.assemble(
        made, {**THESIS, "follower_load": {"edge": "right", "pressure": 2e6, "shear": 1e6}}
    )
    start, step = np.zeros((made.size, 1)), np.array([1.5e-5])
    half, whole = (
        Newmark(tolerance=1e-8, widest_band=width).run(term, start, step, 200) for width in (400, 0)
    )
    assert half.outcomes == whole.outcomes == ["ok"]
    assert (
        np.abs(half.displacement - whole.displacement).max()
        <= 1e-6 * np.abs(whole.displacement).max()
    )
    assert half.iterations <= 1.2 * whole.iterations


def test_a_start_that_is_stretched_far(cantilever):
    """Bent along a straight mode the axis is too long: at the first step the usual guess goes far
    astray, and the tangent there is indefinite.
    """
    made, _ = cantilever
    term = effects.assemble(made, {**UNDAMPED, "rayleigh_damping": {"damping_ratio": 0.01}})
    (omega,), (phi,) = (part[:1] for part in eigenmodes(term, 1))
    start, step = (0.01 / np.abs(phi).max() * phi)[:, None], np.array([2 * np.pi / omega / 1000])
    coarse = Newmark(alpha=0.005).run(term, start, step, 200)
    fine = Newmark(alpha=0.005).run(term, start, step / 8, 1600, record=Record(every=8))
    assert coarse.outcomes == fine.outcomes == ["ok"]
    # The bending is resolved to (omega h)^2/12 a radian, 4e-6 of it over this fifth of a period;
    # the axial swing that comes with it is not.
    tip = np.abs(phi).argmax()
    assert (
        np.abs(coarse.displacement[0, :, tip] - fine.displacement[0, :, tip]).max()
        <= 1e-3 * np.abs(start).max()
    )


WRONG = {
    "displacement": ({"displacement": np.zeros(240)}, r"\(240,\); .* \(n, states\) = \(240, 1\)"),
    "velocity": ({"velocity": np.zeros((240, 2))}, r"\(240, 2\); .* \(n, states\) = \(240, 3\)"),
    "step": ({"step": np.full(1, 1e-5)}, r"\(1,\); .* \(states,\) = \(3,\)"),
    "signal": (
        {"signal": np.zeros((5, 3))},
        r"\(5, 3\); needed is \(steps \+ 1, states\) = \(6, 3\)",
    ),
    "record.probes": ({"record": Record(probes=np.array([3, 240]))}, "240; needed are dofs from 0"),
    "record": ({"record": Record(every=0)}, "every = 0"),
    "steps": ({"steps": -1}, "-1; needed"),
    "initial_acceleration": ({"initial_acceleration": "none"}, "'none' .*equilibrium, zero"),
}


@pytest.mark.parametrize("name", WRONG)
def test_what_does_not_fit_is_named(name, cantilever):
    """Compiled code would read beyond its arrays."""
    given, message = WRONG[name]
    fitting = {"displacement": np.zeros((240, 3)), "step": np.full(3, 1e-5), "steps": 5}
    with pytest.raises(ValueError, match=rf"^{name} ?(has|=|:) .*{message}"):
        Newmark().run(cantilever[1], **{**fitting, **given})


def test_a_scene_without_mass_does_not_move():
    made = space.build(body(cells=[2, 1]))
    term = effects.assemble(made, {"elasticity": LINEAR["elasticity"]})
    with pytest.raises(SceneError, match="effects has no inertia.*list inertia"):
        Newmark().run(term, np.zeros((made.size, 1)), np.array([1e-5]), 1)


def test_nodes_without_mass_have_no_acceleration_of_equilibrium():
    """A mass at the tip alone: from rest the acceleration may be zero, and is then of no weight."""
    made = space.build(body(cells=[2, 1]))
    term = effects.assemble(
        made,
        {
            "elasticity": LINEAR["elasticity"],
            "tip_mass": {"at": [1.0, 0.0], "mass": 1.0},
        },
    )
    start, step = np.zeros((made.size, 1)), np.array([1e-5])
    with pytest.raises(SceneError, match="some node has no mass.*list inertia, or choose"):
        Newmark().run(term, start, step, 1)
    motion = Newmark().run(term, start, step, 1, initial_acceleration="zero")
    assert not motion.displacement.any()


@pytest.mark.parametrize("settings", [{}, {"widest_band": 0}])
def test_a_load_beyond_all_numbers_is_no_motion(settings, cantilever):
    """The squares of its entries are infinite, and infinity is not above infinity."""
    _, term = cantilever
    signal = np.full((6, 1), 1e300)
    start, step = np.zeros((term.size, 1)), np.array([1e-5])
    motion = Newmark(**settings, max_iterations=3).run(
        term, start, step, 5, signal=signal, initial_acceleration="zero"
    )
    assert motion.outcomes == [Outcome.NO_CONVERGENCE] and motion.failed_at == [1e-5]


@pytest.mark.parametrize("effect", [{}, {"geometric_nonlinearity": {}}])
def test_no_step_keeps_the_start(effect):
    made = space.build(body(cells=[2, 1]))
    start = 1e-3 * np.ones((made.size, 2))
    motion = Newmark().run(
        effects.assemble(made, {**LINEAR, **effect}),
        start,
        np.full(2, 1e-5),
        0,
        record=Record(probes=np.array([1])),
    )
    np.testing.assert_array_equal(motion.displacement, start.T[:, None])
    np.testing.assert_array_equal(motion.probes, start.T[:, 1:2, None])


def test_progress_and_chunks_add_up(cantilever):
    """What is kept does not depend on where a chunk of steps ends; progress counts all states."""
    _, term = cantilever
    start, step, seen = 1e-4 * np.ones((term.size, 3)), np.full(3, 1e-5), []
    record = Record(every=3, start=1, probes=np.array([7]), probe_start=2)
    whole = Newmark().run(term, start, step, 50, record=record, progress=seen.append)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("vibrom.solvers.full.banded_steps.chunk", lambda n, width: 4)
        parts = Newmark().run(term, start, step, 50, record=record, progress=seen.append)
    assert sum(seen) == 2 * 150 and len(seen) == 1 + 13
    for name in ("kept", "displacement", "velocity", "acceleration", "probes"):
        np.testing.assert_array_equal(getattr(parts, name), getattr(whole, name))


MOTIONS = """
import numpy as np
from vibrom import effects
from vibrom.bodies import space
from vibrom.solvers.full.newmark import Newmark
from scenes import LINEAR, body
made = space.build(body(cells=[2, 1]))
spring = {"cubic_spring": {"at": [1.0, 0.0], "direction": "y", "cubic": 1e9}}
for states, listed in ((3, LINEAR), (1, {**LINEAR, **spring})):
    rest, step = np.zeros((made.size, states)), np.full(states, 1e-5)
    Newmark().run(effects.assemble(made, listed), rest, step, 3)
"""
COUNTED = """
from numba import njit
from numba.core import event
class Listener(event.Listener):
    def on_start(self, event): print(event.data["dispatcher"].py_func.__qualname__)
    def on_end(self, event): pass
event.register("numba:compile", Listener())
njit(lambda x: x)(1)
"""


def test_a_second_process_compiles_nothing():
    """Loops whose arguments are named tuples and pointers to kernels are kept on disk too: another
    process compiles the one function that nobody kept.
    """
    exec(MOTIONS, {})
    compiled = subprocess.run(
        [sys.executable, "-c", COUNTED + MOTIONS],
        env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)},
        stdout=subprocess.PIPE,
        text=True,
        check=True,
    )
    assert compiled.stdout.split() == ["<lambda>"]
