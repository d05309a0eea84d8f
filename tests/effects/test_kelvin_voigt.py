"""Damping by the rate of strain: scikit-fem's forms, rigid motions, proportional damping."""

from dataclasses import replace

import numpy as np
import pytest
import skfem
from meshes import distorted
from scenes import LINEAR, UNDAMPED, body
from skfem.helpers import ddot, grad, identity, trace

from vibrom import effects
from vibrom.bodies import space
from vibrom.effects.kelvin_voigt import KelvinVoigt
from vibrom.models.energy import energy
from vibrom.solvers.full.modes import eigenmodes
from vibrom.solvers.full.newmark import Newmark
from vibrom.solvers.manifold.force import NoPolynomial, potentials
from vibrom.term import Term

TAU = 1e-3
DAMPED = {**UNDAMPED, "kelvin_voigt": {"retardation_time": TAU}}
CASES = [("quad", "strain"), ("triangle6", "stress"), ("hexahedron", "stress"), ("wedge", "stress")]


def built(kind, plane="stress", clamped=()):
    made = distorted(kind, clamped, True)
    return made, effects.assemble(
        made, {**DAMPED, "elasticity": {**LINEAR["elasticity"], "plane": plane}}
    )


def viscous(term, q, v):
    """C v + f(q, v) of both arrays (n,)."""
    force, f = term.forces[1], np.zeros((len(q), 1))
    force.kernels(1)[0](q[:, None].copy(), v[:, None].copy(), force.dofs, force.table, f)
    return term.damping @ v + f[:, 0]


def states(made):
    rng = np.random.default_rng(3)
    return 0.2 * rng.standard_normal((2, made.size))


@pytest.mark.parametrize(("kind", "plane"), CASES)
def test_the_force_is_that_of_scikit_fem(kind, plane):
    """int F D : sym(F'K) : grad test, on distorted elements with the same quadrature."""
    made, term = built(kind, plane)
    (q, v), young, nu = states(made), 104.0e9, 0.3
    thin = made.dimension == 2 and plane == "stress"
    first = young * nu / ((1 - nu**2) if thin else (1 + nu) * (1 - 2 * nu))

    @skfem.LinearForm
    def form(test, w):
        f, k = grad(w["q"]) + identity(grad(w["q"])), grad(w["v"])
        rate = np.einsum("ki...,kj...->ij...", f, k)
        rate = 0.5 * (rate + np.einsum("ij...->ji...", rate))
        stress = first * trace(rate) * identity(f) + young / (1 + nu) * rate
        first_stress = np.einsum("ik...,kj...->ij...", f, stress)
        return TAU * made.thickness * ddot(first_stress, grad(test))

    whole = np.zeros((2, made.basis.N))
    whole[:, made.free] = q, v
    fields = dict(zip("qv", map(made.basis.interpolate, whole)))
    expected = form.assemble(made.basis, **fields)[made.free]
    np.testing.assert_allclose(
        viscous(term, q, v), expected, rtol=0, atol=1e-12 * np.abs(expected).max()
    )
    assert v @ viscous(term, q, v) > 0.0


@pytest.mark.parametrize("kind", [kind for kind, _ in CASES])
def test_a_rigid_rotation_costs_nothing(kind):
    """About any axis, of a body that has turned far; K v does not vanish there."""
    made, term = built(kind)
    dim = made.dimension
    turn = np.linalg.qr(np.random.default_rng(1).standard_normal((dim, dim)))[0]
    turn[0] *= np.linalg.det(turn)
    spin = np.zeros((dim, dim))
    spin[np.triu_indices(dim, 1)] = [3.0, -1.0, 2.0][: dim * (dim - 1) // 2]
    spin = spin - spin.T
    along = made.dof_axis
    place = made.dof_location[:, :dim] @ turn.T
    q = place[np.arange(made.size), along] - made.dof_location[np.arange(made.size), along]
    v = (place @ spin.T)[np.arange(made.size), along]
    scale = np.abs(term.damping) @ np.abs(v)
    assert np.abs(viscous(term, q, v)).max() < 1e-12 * scale.max()
    assert v @ (term.damping @ v) > 1e-3 * np.abs(v) @ scale


@pytest.mark.parametrize("kind", ["quad9", "tetra10"])
def test_small_motions_are_damped_in_proportion_to_the_stiffness(kind):
    """zeta = tau omega/2; a linear body has no more than that."""
    made, term = built(kind, clamped=("left",))
    expected = TAU * term.stiffness
    assert abs(term.damping - expected).max() < 1e-12 * abs(expected).max()
    q, v = 1e-6 * states(made)
    added = viscous(term, q, v) - term.damping @ v
    assert np.linalg.norm(added) < 1e-4 * np.linalg.norm(term.damping @ v)
    linear = effects.assemble(made, {**LINEAR, "kelvin_voigt": {"retardation_time": TAU}})
    assert not linear.forces and abs(linear.damping - term.damping).max() == 0.0


def spinning(damped, steps=200):
    """Kinetic and elastic energy (steps + 1,) of a free plate of rubber that spins at 1 rad/s, in
    two turns.
    """
    made = space.build(body(cells=[1, 1], height=0.5, clamped=[]))
    rubber = {**UNDAMPED, "elasticity": {"young_modulus": 1e7, "poisson_ratio": 0.3}}
    term = damped(effects.assemble(made, rubber), made)
    place, axis = made.dof_location, made.dof_axis
    v = np.where(axis == 0, 0.25 - place[:, 1], place[:, 0] - 0.5)
    motion = Newmark(scheme="energy_momentum", tolerance=1e-9).run(
        term,
        np.zeros((made.size, 1)),
        np.array([4 * np.pi / steps]),
        steps,
        velocity=v[:, None],
        initial_acceleration="zero",
    )
    assert motion.outcomes == ["ok"]
    bare = effects.assemble(made, rubber)
    return energy(bare, motion.displacement[0], motion.velocity[0], np.zeros(made.size))


def test_a_spinning_body_keeps_its_energy_and_loses_it_to_the_undeformed_stiffness():
    """The spin stretches it by rho L^2/E, 1e-5, of its size: that much of its energy breathes and
    is damped, and no more is lost.
    """
    viscous = KelvinVoigt(1e-5)
    kept = spinning(lambda term, made: term + viscous.assemble(made, term))
    assert (np.diff(kept) < 1e-7 * kept[0]).all()  # never gained, but for Newton's tolerance
    assert kept[-1] > (1 - 4e-5) * kept[0]
    lost = spinning(lambda term, made: replace(term, damping=1e-5 * term.stiffness))
    assert lost[-1] < 0.5 * lost[0]


def test_a_mode_decays_by_its_ratio():
    """By exp(-2 zeta omega t) in energy, zeta = tau omega/2, less Newmark's (omega h)^2."""
    made = space.build(body(cells=[8, 1], element="quadratic"))
    zeta = 0.02
    first = eigenmodes(effects.assemble(made, UNDAMPED), 1)
    omega = first.frequency[0]
    damped = {**UNDAMPED, "kelvin_voigt": {"retardation_time": 2 * zeta / omega}}
    term, start = effects.assemble(made, damped), 1e-5 * first.shape[0]
    h = np.array([2 * np.pi / omega / 200])
    motion = Newmark(tolerance=1e-9).run(term, start[:, None], h, 1000)
    linear = Term(mass=term.mass, stiffness=term.stiffness)
    stored = energy(linear, motion.displacement[0], motion.velocity[0], np.zeros(made.size))
    expected = -2 * zeta * omega * 1000 * h[0]
    assert np.log(stored[-1] / stored[0]) == pytest.approx(expected, rel=2e-3)


def test_series_refuse_it_by_name():
    _, term = built("quad")
    with pytest.raises(NoPolynomial, match=r"effects.kelvin_voigt: its force is no cubic"):
        potentials(term)
