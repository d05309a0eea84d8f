"""Newmark's ways to one motion agree: a batch and each state alone, a band and a sparse matrix,
displacements and accelerations, chunks of steps, and what other processes compiled.
"""

import os
import subprocess
import sys

import numpy as np
import pytest
from scenes import LINEAR, THESIS

from vibrom import effects
from vibrom.solvers.full.newmark import Newmark, Record
from vibrom.solvers.full.static import equilibrium


def test_batch_equals_loop(cantilever):
    """Thirteen states go in a batch of sixteen, four in one of eight."""
    made, term = cantilever
    steps, forcing = 300, np.array([1.0, 600.0, 3000.0, 6000.0])
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
        Newmark(tolerance=1e-8, widest_band=width).run(term, start, step, 100) for width in (400, 0)
    )
    assert half.outcomes == whole.outcomes == ["ok"]
    assert (
        np.abs(half.displacement - whole.displacement).max()
        <= 1e-6 * np.abs(whole.displacement).max()
    )
    assert half.iterations <= 1.2 * whole.iterations


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


def test_another_process_compiles_nothing():
    """Loops whose arguments are named tuples and pointers to kernels are kept on disk too: another
    process compiles the one function that nobody kept. Once it may be one more: of two that save at
    the same instant, as tests do that run beside these, the list of what is kept is that of one.
    """
    exec(MOTIONS, {})
    for _ in range(2):
        compiled = subprocess.run(
            [sys.executable, "-c", COUNTED + MOTIONS],
            env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)},
            stdout=subprocess.PIPE,
            text=True,
            check=True,
        ).stdout.split()
        if compiled == ["<lambda>"]:
            break
    assert compiled == ["<lambda>"]
