"""Return maps: derivatives against differences, multipliers against independent integrations, half
periods against whole ones, and the motion itself against long time marching.
"""

from dataclasses import fields, replace

import numpy as np
import periodic_systems as systems
import pytest
from periodic_beam import CASES, STOP, beam, periodic
from scenes import CANTILEVER, THESIS
from scipy.integrate import solve_ivp

from vibrom import effects
from vibrom.bodies import space
from vibrom.models.model import Drive, Watch
from vibrom.models.rollout import Integrator
from vibrom.solvers.full.newmark import Newmark
from vibrom.solvers.periodic import symmetry
from vibrom.solvers.periodic.coordinates import NoState
from vibrom.solvers.periodic.equations import from_rest
from vibrom.solvers.periodic.newmark_map import NewmarkMap


@pytest.mark.parametrize("name", CASES)
def test_the_derivative_is_that_of_the_steps(name):
    """Central differences of the map, and of what is in phase with the load, along random
    directions, along frequency and amplitude.
    """
    extra, options = CASES[name]
    flow = beam(extra, **options)
    assert flow.parts == (2 if name in ("mirrored", "stiffness damping", "sparse") else 1)
    random = np.random.default_rng(3)
    amplitude, frequency = 2e4, 1500.0
    x = flow(np.zeros(flow.size), frequency, amplitude, derivative=False).end
    found = flow(x, frequency, amplitude)
    by_x = np.vstack([found.by_start, found.in_phase_by[:-2]])
    size = np.linalg.norm(x)

    def change(*steps):
        """Half of what changes between a step forth and a step back, and its own size."""
        one, other = (
            flow(
                x + sign * steps[0], frequency + sign * steps[1], amplitude + sign * steps[2], False
            )
            for sign in (1, -1)
        )
        both = [np.append(item.end, item.in_phase) for item in (one, other)]
        return 0.5 * (both[0] - both[1])

    def close(one, other):
        for part in (slice(0, -1), slice(-1, None)):
            assert np.linalg.norm((one - other)[part]) < 2e-4 * np.linalg.norm(other[part])

    for _ in range(3):
        along = random.standard_normal(flow.size)
        along *= 1e-4 * size / np.linalg.norm(along)
        close(by_x @ along, change(along, 0.0, 0.0))
    own = np.append(found.by_frequency, found.in_phase_by[-2])
    close(1e-5 * frequency * own, change(0.0, 1e-5 * frequency, 0.0))
    own = np.append(found.by_amplitude, found.in_phase_by[-1])
    close(1e-4 * amplitude * own, change(0.0, 0.0, 1e-4 * amplitude))


def test_a_state_is_found_from_its_point_wherever_the_search_begins():
    """From torn elements Newton's iteration fails, and begins again at rest."""
    flow = beam()
    n, coordinates = flow.term.size, flow._coordinates
    bent = flow.state(flow(np.zeros(2 * n), 1500.0, 3e6, derivative=False).end)
    x = flow.of_state(bent)
    assert np.abs(bent[:n]).max() > 0.04
    torn = 100.0 * np.random.default_rng(0).standard_normal(n)
    with pytest.raises(NoState):
        coordinates._search(x[:n], torn)
    coordinates.near[:] = [torn]
    np.testing.assert_allclose(flow.state(x), bent, atol=1e-9 * np.abs(bent).max())


def test_half_a_period_twice_is_a_whole_one():
    half, whole = beam(), beam(mirrored=False)
    assert (half.parts, whole.parts) == (2, 1)
    x = periodic(half, 1500.0, 2e4)
    once = half(x, 1500.0, 2e4)
    full = whole(x, 1500.0, 2e4)
    np.testing.assert_allclose(full.end, x, atol=1e-6 * np.linalg.norm(x))
    # At a periodic motion the second half's derivative is the first one's.
    twice = once.by_start @ once.by_start
    assert np.abs(twice - full.by_start).max() < 1e-5 * np.abs(full.by_start).max()
    one, other = (
        flow.swings(x[None], np.array([1500.0]), np.array([2e4])) for flow in (half, whole)
    )
    np.testing.assert_allclose(one[0].displacement, other[0].displacement, rtol=1e-5, atol=1e-9)


def test_half_a_period_is_enough_for_a_body_in_space():
    """It bends along z, its thinner side: the mirror about the middle of z turns the load, and so
    does half a turn about x. Nodes in the middle of a side stay there, whatever the body's length.
    """
    size = {"length": 1.0, "height": 0.1, "width": 0.06, "cells": [2, 1, 1], "probes": {}}
    made = space.build({"shape": "block", **size, "element": "serendipity", "clamped": ["left"]})
    elastic = {"young_modulus": 104.0e9, "poisson_ratio": 0.3}
    term = effects.assemble(made, {**THESIS, "elasticity": elastic})
    odd, *mirrors = symmetry.candidates(made.dof_location, made.dof_axis, made.size)
    assert not symmetry.holds(odd, term)
    assert [symmetry.holds(mirror, term) for mirror in mirrors] == [True, False, True]
    probes = np.array([made.size - 1])
    rest, settings = np.zeros(made.size), Newmark(alpha=0.005)
    half = NewmarkMap(term, settings, 60, 1000.0, probes, rest, mirrors[0])
    x = periodic(half, 700.0, 1e3)
    end = replace(half, symmetry=None)(x, 700.0, 1e3, derivative=False).end
    np.testing.assert_allclose(end, x, atol=1e-6 * np.linalg.norm(x))


def test_multipliers_of_a_linear_oscillator_are_those_of_the_method():
    """The amplification matrix of Newmark's method, written out for one displacement."""
    flow = systems.full_order(**systems.DUFFING | {"cubic": [0.0]}, alpha=0.01).return_map()
    frequency, damping = 0.9, systems.DUFFING["damping"]
    h = 2 * np.pi / frequency / flow.steps_per_period
    gamma, beta = 0.51, 0.25 * 1.01**2
    # (q, v, a) -> (q, v, a), by  a' (1 + gamma h c + beta h^2) = -c v~ - q~
    ahead = np.array([[1.0, h, h * h * (0.5 - beta)], [0.0, 1.0, h * (1 - gamma)]])
    fall = -(damping * ahead[1] + ahead[0]) / (1 + gamma * h * damping + beta * h * h)
    step = np.stack([ahead[0] + beta * h * h * fall, ahead[1] + gamma * h * fall, fall])
    start = np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, -damping]])
    steps = flow.steps_per_period // flow.parts
    whole = (np.linalg.matrix_power(step, steps) @ start)[:2]
    sign = -1.0 if flow.parts == 2 else 1.0
    ours = np.sort_complex(flow(np.ones(2), frequency, 0.1).multipliers)
    np.testing.assert_allclose(ours, np.sort_complex(sign * np.linalg.eigvals(whole)), atol=1e-9)


def duffing_flow(t, y, frequency, amplitude):
    """The oscillator and its variational equation (two columns)."""
    x, v, phi = y[0], y[1], y[2:].reshape(2, 2)
    c = systems.DUFFING["damping"]
    slope = np.array([[0.0, 1.0], [-1.0 - 3.0 * x**2, -c]])
    force = amplitude * np.sin(frequency * t)
    return np.concatenate([[v, -x - x**3 - c * v + force], (slope @ phi).ravel()])


@pytest.mark.parametrize("kind", ["full order", "reduced", "reduced in numpy"])
def test_multipliers_are_those_of_the_variational_equation(kind):
    """Duffing's oscillator where it folds, integrated by SciPy with its variational equation."""
    frequency, amplitude = 1.3, 0.2
    if kind == "full order":
        flow = systems.full_order(**systems.DUFFING, steps=4000).return_map()
        flow = replace(flow, symmetry=None)
        tolerance = 1e-5  # (omega h)^2/12 = 2e-7 a radian, and stability turns on a few radians
    else:
        flow = replace(systems.reduced(**systems.DUFFING).return_map(), parts=1)
        flow = replace(flow, field=None) if kind == "reduced in numpy" else flow
        tolerance = 3e-7  # of a step's estimated error, 1e-6, this much is left in a period
    x = periodic(flow, frequency, amplitude)
    state = flow.state(x)
    np.testing.assert_allclose(flow.of_state(state), x, atol=1e-9)
    exact = solve_ivp(
        duffing_flow,
        (0, 2 * np.pi / frequency),
        [*state, 1, 0, 0, 1],
        args=(frequency, amplitude),
        method="DOP853",
        rtol=1e-12,
        atol=1e-12,
    ).y[:, -1]
    found = flow(x, frequency, amplitude)
    np.testing.assert_allclose(flow.state(found.end), exact[:2], atol=tolerance)
    multipliers = np.sort_complex(np.linalg.eigvals(exact[2:].reshape(2, 2)))
    np.testing.assert_allclose(np.sort_complex(found.multipliers), multipliers, atol=10 * tolerance)
    # Liouville: the product is exp(-c T), whatever the motion.
    product = np.exp(-systems.DUFFING["damping"] * 2 * np.pi / frequency)
    assert np.prod(found.multipliers).real == pytest.approx(product, abs=tolerance)


def test_a_periodic_motion_is_where_time_marching_ends():
    """To 1e-5 of its size, as the steps that march leave 1e-6 of their forces."""
    flow = beam({"rayleigh_damping": {"damping_ratio": 0.1}})
    x = periodic(flow, 1500.0, 2e4)
    ended = flow.after(np.zeros(flow.size), 1500.0, 2e4, 40)
    assert np.linalg.norm(ended - x) < 1e-5 * np.linalg.norm(x)
    swings = flow.swings(np.stack([x, ended]), np.full(2, 1500.0), np.full(2, 2e4))
    one, other = (swing.displacement.max() for swing in swings)
    assert one == pytest.approx(other, rel=1e-5)


def test_work_of_the_load_is_what_damping_takes():
    """Over a period of a motion without numerical damping:  int p.v u dt = int v'Cv dt."""
    model = systems.full_order(**systems.TWO, steps=2000)
    flow = model.return_map()
    for frequency in (0.6, 0.75, 0.9):
        x = periodic(flow, frequency, 0.05, from_rest(flow, frequency, 0.05))
        q, v = np.split(flow.state(x), 2)
        steps = flow.steps_per_period
        signal = 0.05 * np.sin(2 * np.pi * np.arange(steps + 1) / steps)[:, None]
        step = np.array([2 * np.pi / frequency / steps])
        motion = replace(flow.newmark, tolerance=1e-10).run(
            flow.term, q[:, None], step, steps, velocity=v[:, None], signal=signal
        )
        velocity = motion.velocity[0, :-1]
        work = (velocity @ flow.term.load) @ signal[:-1, 0] * step[0]
        lost = np.einsum("ti,ij,tj->", velocity, flow.term.damping.toarray(), velocity) * step[0]
        assert work == pytest.approx(lost, rel=1e-4)


def test_symmetries_are_told_from_forces():
    made = space.build(CANTILEVER)
    term = effects.assemble(made, THESIS)
    odd, *mirrors = symmetry.candidates(made.dof_location, made.dof_axis, made.size)
    assert not symmetry.holds(odd, term)  # a bent beam shortens, whichever way it bends
    assert [symmetry.holds(mirror, term) for mirror in mirrors] == [True, False, False]
    stopped = effects.assemble(made, {**THESIS, "stop": {**STOP, "at": [1.0, 0.01]}})
    assert not any(symmetry.holds(item, stopped) for item in [odd, *mirrors])
    spring = systems.full_order(**systems.TWO)
    (odd,) = symmetry.candidates(None, None, 2)
    assert symmetry.holds(odd, spring.term)


def test_a_motion_that_does_not_last_is_no_error():
    """A softening spring beyond its hill."""
    soft = systems.DUFFING | {"cubic": [-1.0]}
    for flow in (systems.reduced(**soft).return_map(), systems.full_order(**soft).return_map()):
        found = flow(flow.of_state(np.array([3.0, 0.0])), 1.0, 0.0)
        assert not found.ok or np.linalg.norm(found.end) > 1e3


def test_what_a_load_adds_beside_a_manifold_is_in_the_motion_over_a_period():
    """As in a long run of the same model, whose steps are others."""
    plain = systems.reduced(**systems.DUFFING)

    class Beside(type(plain.rom)):
        def beside(self, z, p, dofs=None):
            return np.stack([0.3 * z[..., :1], 0.1 + 0.0 * z[..., :1]])

    rom = Beside(**{item.name: getattr(plain.rom, item.name) for item in fields(plain.rom)})
    model = replace(plain, rom=rom, integrator=Integrator(rtol=1e-11, atol=1e-12))
    frequency, amplitude, periods = 0.7, 0.1, 60  # what is left of the start: exp(-0.02 * 540)
    flow = model.return_map()
    swing = flow.swings(
        from_rest(flow, frequency, amplitude)[None], np.array([frequency]), np.array([amplitude])
    )[0].displacement
    instants = 2.0 * np.pi / frequency * (periods + np.arange(64) / 64)
    drive = Drive(np.array([amplitude]), np.array([frequency]))
    run = model.motion(np.zeros((1, 2)), drive, Watch(instants, model.probes))
    np.testing.assert_allclose(swing[0, ::8], run.displacement[0][0, :, 0], atol=1e-4)
    alone = (
        plain.return_map()
        .swings(
            from_rest(flow, frequency, amplitude)[None],
            np.array([frequency]),
            np.array([amplitude]),
        )[0]
        .displacement
    )
    assert np.abs(swing - alone).max() > 0.005


def test_a_derivative_along_some_shapes_is_that_part_of_the_whole():
    """dH/dx P P' and d(in phase)/dx P P', of shapes that are any; along frequency and amplitude
    nothing changes.
    """
    flow, n = beam(), beam().term.size
    shapes = np.random.default_rng(5).standard_normal((n, 4))
    some = flow.only(shapes)
    x = flow(np.zeros(2 * n), 1500.0, 2e4, derivative=False).end
    whole, part = flow(x, 1500.0, 2e4), some(x, 1500.0, 2e4)
    p = np.zeros((2 * n, 8))
    p[:n, :4], p[n:, 4:] = some.along
    np.testing.assert_allclose(p.T @ p, np.eye(8), atol=1e-12)
    np.testing.assert_allclose(part.end, whole.end, atol=1e-9 * np.abs(whole.end).max())
    for name in ("by_start", "by_frequency", "by_amplitude", "in_phase_by"):
        own, all_of_it = getattr(part, name), getattr(whole, name)
        if name == "by_start":
            all_of_it = all_of_it @ p @ p.T
        elif name == "in_phase_by":
            all_of_it = np.append(all_of_it[:-2] @ p @ p.T, all_of_it[-2:])
        np.testing.assert_allclose(own, all_of_it, rtol=0.0, atol=1e-9 * np.abs(all_of_it).max())
