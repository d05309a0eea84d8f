"""What holds for every file of `effects/`, found by listing the folder: a new effect is tested
without a word here.
"""

import dataclasses
import importlib
from dataclasses import replace
from pathlib import Path
from typing import get_args, get_type_hints

import numpy as np
import pytest
from scenes import body

from vibrom import effects
from vibrom.bodies import space
from vibrom.kernels import banded
from vibrom.models.energy import work
from vibrom.solvers.full.tangent import Tangent
from vibrom.term import Term

NAMES = sorted(
    path.stem for path in Path(effects.__file__).parent.glob("*.py") if path.stem != "__init__"
)
# Settings of any effect on a body of 1 m x 0.2 m (x 0.1 m): by name where a number will not do,
# else 0.3; and those that only bodies of the other dimension have.
PLACED = {"at": [1.0, 0.1], "direction": "y", "edge": "right"}
NUMBER = 0.3
OTHERS = {2: {"z"}, 3: {"shear"}}
AFTER = {"kelvin_voigt": ("geometric_nonlinearity",)}  # what gives an effect its force
STATES = 16


def settings(name: str, dimension: int) -> dict:
    """A value for each setting of an effect that has no choice of its own."""
    module = importlib.import_module(f"vibrom.effects.{name}")
    (kind,) = (item for item in vars(module).values() if hasattr(item, "assemble"))
    hints, chosen = get_type_hints(kind), {}
    for field in dataclasses.fields(kind):
        if field.name in OTHERS[dimension]:
            continue
        if field.name == "at":
            chosen[field.name] = [*PLACED["at"], 0.1][:dimension]
        elif field.name in PLACED:
            chosen[field.name] = PLACED[field.name]
        elif hints[field.name] is float:
            chosen[field.name] = NUMBER
        elif field.default is dataclasses.MISSING:
            chosen[field.name] = get_args(hints[field.name])[0]  # of a Literal
    return chosen


@pytest.fixture(scope="module", params=["bilinear", "quadratic", "serendipity", "block"])
def made(request):
    size = {"height": 0.2, "element": request.param}
    if request.param == "block":
        size |= {"shape": "block", "width": 0.1, "element": "trilinear", "cells": [1, 2, 1]}
    return space.build(body(**{"cells": [2, 2], **size}))


def listed(name: str, made) -> dict[str, dict]:
    """The effect after those that it may need."""
    needed = ("inertia", "elasticity", *AFTER.get(name, ()), name)
    return {effect: settings(effect, made.dimension) for effect in needed}


def states(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Displacements and velocities (n, STATES), some of them far."""
    rng, far = np.random.default_rng(5), np.geomspace(0.01, 3.0, STATES)
    return rng.standard_normal((n, STATES)) * far, rng.standard_normal((n, STATES)) * far


def force(term: Term, q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Sum of f(q, v) (n, states), by the kernels for that number of states."""
    f = np.zeros_like(q)
    for one in term.forces:
        one.kernels(q.shape[1])[0](q, v, one.dofs, one.table, f)
    return f


def alone(array: np.ndarray, state: int) -> np.ndarray:
    return np.ascontiguousarray(array[:, [state]])


@pytest.mark.parametrize("name", NAMES)
def test_it_adds_something_of_the_right_shape(name, made):
    """And what is constant is a number."""
    needed = [other for other in ("inertia", "elasticity") if other != name]
    base = effects.assemble(made, {other: settings(other, made.dimension) for other in needed})
    term = effects.load(name, settings(name, made.dimension)).assemble(made, base)
    parts = {field.name: getattr(term, field.name) for field in dataclasses.fields(term)}
    assert not parts.pop("driven")
    assert parts.pop("forces") or any(part is not None for part in parts.values())
    n, dim = made.size, made.dimension
    strains = dim * (dim + 1) // 2
    shapes = {"load": (n,), "dead_load": (n,), "elastic": (strains,) * 2, "carried": (n, dim)}
    for field, part in parts.items():
        if part is not None:
            assert part.shape == shapes.get(field, (n, n))
            assert np.isfinite(getattr(part, "data", part)).all()


@pytest.mark.parametrize("name", NAMES)
def test_its_matrices_are_symmetric_and_its_forces_vanish_at_rest(name, made):
    term = effects.assemble(made, listed(name, made))
    for matrix in (term.mass, term.damping, term.stiffness):
        if matrix is not None:
            assert abs(matrix - matrix.T).max() <= 1e-14 * abs(matrix).max()
    assert not force(term, np.zeros((made.size, 1)), np.zeros((made.size, 1))).any()


@pytest.mark.parametrize("name", NAMES)
def test_listed_twice_it_adds_twice(name, made):
    """What it adds to the effects before it; a load may act more than once, and so may all."""
    (q, v), once = states(made.size), listed(name, made)
    others = {effect: chosen for effect, chosen in once.items() if effect != name}
    without, single, double = (
        parts(effects.assemble(made, each), q, v)
        for each in (others, once, {**once, name: [once[name], once[name]]})
    )
    for none, one, two in zip(without, single, double):
        assert np.abs(two - none - 2 * (one - none)).max() <= 1e-12 * np.abs(one).max()


def parts(term: Term, q: np.ndarray, v: np.ndarray) -> list[np.ndarray]:
    """Its matrices, its loads and its forces at these states."""
    matrices = [term.mass, term.damping, term.stiffness]
    made = [np.zeros((len(q),) * 2) if part is None else part.toarray() for part in matrices]
    made += [np.zeros(len(q)) if part is None else part for part in (term.load, term.dead_load)]
    return [*made, force(term, q, v)]


@pytest.mark.parametrize("name", NAMES)
def test_its_tangent_is_the_derivative_of_its_force(name, made):
    """By displacements and by velocities, dof by dof. Central differences with Richardson's
    extrapolation are exact up to the fourth degree.
    """
    term = dataclasses.replace(
        effects.assemble(made, listed(name, made)), mass=None, damping=None, stiffness=None
    )
    if not term.forces:
        return
    n, step, largest = made.size, 1e-3, 0.0
    term = dataclasses.replace(term, load=np.zeros(n))
    q, v = states(n)
    for state in range(STATES):
        at = alone(q, state), alone(v, state)
        for scales, moved in (((0.0, 0.0, 1.0), 0), ((0.0, 1.0, 0.0), 1)):
            columns = []
            for dof in range(n):
                f = {}
                for times in (-2, -1, 1, 2):
                    there = [part.copy() for part in at]
                    there[moved][dof] += times * step
                    f[times] = force(term, *there)[:, 0]
                columns.append((8 * (f[1] - f[-1]) - (f[2] - f[-2])) / (12 * step))
            tangent = Tangent(term, *scales).at(*at).toarray()
            expected = np.array(columns).T
            largest = max(largest, np.abs(expected).max())
            size = max(np.abs(force(term, *at)).max(), np.abs(expected).max())
            # Rounding of the force over the step.
            np.testing.assert_allclose(tangent, expected, rtol=0, atol=1e-10 * size)
    assert largest > 0.0


@pytest.mark.parametrize("name", NAMES)
def test_states_side_by_side_are_each_as_alone(name, made):
    """Its force, and its tangent in the band."""
    term = effects.assemble(made, listed(name, made))
    q, v = states(made.size)
    together, half = force(term, q, v), made.size - 1
    for state in range(STATES):
        single = force(term, alone(q, state), alone(v, state))[:, 0]
        assert np.abs(together[:, state] - single).max() <= 1e-13 * np.abs(single).max(initial=0.0)
    rng = np.random.default_rng(6)
    scale_q, scale_v = rng.uniform(0.5, 2.0, (2, STATES))
    for one in term.forces:
        slots = banded.band_slots(one.dofs, half, one.symmetric)
        band = np.zeros((made.size * (half + 1), STATES))
        one.kernels(STATES)[1](q, v, one.dofs, one.table, slots, scale_q, scale_v, band)
        for state in range(STATES):
            single, some = np.zeros((len(band), 1)), slice(state, state + 1)
            at = alone(q, state), alone(v, state)
            scales = scale_q[some], scale_v[some]
            one.kernels(1)[1](*at, one.dofs, one.table, slots, *scales, single)
            size = np.abs(single).max(initial=0.0)
            assert np.abs(band[:, state] - single[:, 0]).max() <= 1e-13 * size


@pytest.mark.parametrize("name", NAMES)
def test_a_force_that_says_so_has_a_potential(name, made):
    """Its derivative by displacements is symmetric, and it does not see velocities."""
    term = effects.assemble(made, listed(name, made))
    q, v = states(made.size)
    for one in term.forces:
        alike, bare = [], Term(forces=(one,), load=np.zeros(made.size))
        for state in range(STATES):
            at = alone(q, state), alone(v, state)
            by_q, by_v = (Tangent(bare, 0.0, *which).at(*at) for which in ((0.0, 1.0), (1.0, 0.0)))
            size = max(abs(by_q).max(), abs(by_v).max())
            alike.append(max(abs(by_q - by_q.T).max(), abs(by_v).max()) <= 1e-12 * size)
        assert all(alike) == one.conservative


@pytest.mark.parametrize("name", NAMES)
def test_its_mean_force_does_the_work_of_its_potential(name, made):
    """From q - d to q + d, against an integral of the force along the path; and its tangent is the
    derivative by the end of a step whose start stays. The same side by side as alone.
    """
    term = effects.assemble(made, listed(name, made))
    n, step, rng = made.size, 1e-3, np.random.default_rng(8)
    for one in term.forces:
        if one.mean is None:
            continue
        mean, bare = one.over_a_step(), Term(forces=(one,), load=np.zeros(n))
        wide = np.concatenate(
            [
                part * np.geomspace(0.01, 1.0, STATES)
                for part in (rng.standard_normal((n, STATES)),) * 2
            ]
        )
        wide[n:] = 0.3 * rng.standard_normal((n, STATES)) * np.abs(wide[:n]).max(axis=0)
        still, together = np.zeros((n, STATES)), np.zeros((n, STATES))
        mean.kernels(STATES)[0](wide, still, one.dofs, one.table, together)
        for state in range(0, STATES, 5):
            path, rest = alone(wide, state), np.zeros((n, 1))
            single = mean_force(mean, path, rest)
            size = np.abs(single).max()
            assert np.abs(together[:, state] - single[:, 0]).max() <= 1e-13 * size
            middle, half = path[:n], path[n:]
            done = float(np.sum(2 * half * single))
            expected = work(bare, 2 * half, middle - half)[0]
            assert done == pytest.approx(expected, rel=1e-7, abs=1e-9 * size)
            at_rest = np.concatenate([middle, 0 * half])
            np.testing.assert_allclose(
                mean_force(mean, at_rest, rest),
                force(bare, middle, rest),
                rtol=1e-12,
                atol=1e-12 * size,
            )
            tangent = Tangent(replace(bare, forces=(mean,)), 0.0, 0.0, 1.0).at(path, rest)
            along = rng.standard_normal((n, 1))
            ends = [
                mean_force(mean, path + times * step * np.tile(along, (2, 1)), rest)
                for times in (-2, -1, 1, 2)
            ]
            slope = (8 * (ends[2] - ends[1]) - (ends[3] - ends[0])) / (12 * step)
            np.testing.assert_allclose(tangent @ along, slope, atol=1e-9 * np.abs(slope).max())


def mean_force(mean, path: np.ndarray, v: np.ndarray) -> np.ndarray:
    f = np.zeros_like(v)
    mean.kernels(1)[0](path, v, mean.dofs, mean.table, f)
    return f
