"""Energy of full-order states against closed forms, the integral over the elements, and along an
undamped motion.
"""

import numpy as np
import pytest
import skfem
from scenes import ELASTICITY, UNDAMPED, body
from scipy.sparse import csr_matrix
from skfem.helpers import ddot, grad, identity, trace

from vibrom import effects
from vibrom.bodies import space
from vibrom.effects.stop import _force as stop_force
from vibrom.models.energy import TOLERANCE, energy
from vibrom.solvers.full.modes import linearised
from vibrom.solvers.full.newmark import Newmark
from vibrom.term import Force, Term, force_kernel

RNG = np.random.default_rng(0)


@pytest.mark.parametrize("element", ["bilinear", "quadratic"])
def test_strain_energy_is_the_integral_of_its_density(element):
    made = space.build(body(element=element, cells=[5, 2], height=0.1))
    term = effects.assemble(made, UNDAMPED)
    young, nu = ELASTICITY["young_modulus"], ELASTICITY["poisson_ratio"]

    @skfem.Functional
    def density(w):
        h = grad(w["u"])
        f = h + identity(h)
        strain = 0.5 * (np.einsum("ki...,kj...->ij...", f, f) - identity(h))
        return made.thickness * (
            0.5 * young * nu / (1 - nu**2) * trace(strain) ** 2
            + 0.5 * young / (1 + nu) * ddot(strain, strain)
        )

    states = 0.05 * RNG.standard_normal((11, made.size))
    for q, found in zip(states, energy(term, states, np.zeros_like(states), np.zeros(made.size))):
        whole = np.zeros(made.basis.N)
        whole[made.free] = q
        # The same integral by the same points: roundings only.
        assert found == pytest.approx(
            density.assemble(made.basis, u=made.basis.interpolate(whole)), rel=1e-12
        )


@pytest.mark.parametrize("loads", [{}, {"gravity": {"y": -3e4}}])
def test_an_undamped_motion_keeps_it(loads):
    """Also about the equilibrium under a weight that bends the body by two thirds of what the
    motion does.
    """
    made = space.build(body(cells=[10, 2], height=0.1))
    term = effects.assemble(made, UNDAMPED | loads)
    rest, _ = linearised(term)
    x = made.basis.mesh.p[:, : made.basis.mesh.nvertices]
    bent = np.zeros(made.basis.N)
    bent[made.basis.nodal_dofs[1]] = 0.02 * x[0] ** 2
    drifts = []
    for steps in (400, 800):
        motion = Newmark(tolerance=1e-10).run(
            term, (rest + bent[made.free])[:, None], np.array([0.004 / steps]), steps
        )
        values = energy(term, motion.displacement[0] - rest, motion.velocity[0], rest)
        drifts.append(np.abs(values / values[0] - 1).max())
    assert (
        values[0] > 0.0
        and energy(term, np.zeros((1, made.size)), np.zeros((1, made.size)), rest) == 0.0
    )
    # The trapezoidal rule keeps it to the second order of the step.
    assert drifts[1] < 0.35 * drifts[0] and drifts[1] < 0.02


def one_mass(*forces, stiffness=3.0):
    """A mass of 2 kg on a spring, with these forces."""
    part = csr_matrix([[1.0]])
    return Term(mass=2.0 * part, stiffness=stiffness * part, forces=forces)


@force_kernel
def _quintic(q, v, dofs, table, f):
    for w in range(q.shape[1]):
        f[dofs[0, 0], w] += table[0, 0] * q[dofs[0, 0], w] ** 5


def test_of_a_quintic_spring_it_is_the_sixth_power():
    """E = k u^2/2 + k_5 ((u_0 + u)^6 - u_0^6)/6 + k u_0 u, from a rest at u_0."""
    quintic = Force(lambda width: (_quintic, None), np.array([[0]]), np.array([[7.0]]))
    u, rest = np.array([[0.3], [-0.8], [1.7]]), 0.2
    expected = 1.5 * u**2 + 3.0 * rest * u + 7.0 * ((rest + u) ** 6 - rest**6) / 6.0
    found = energy(one_mass(quintic), u, np.zeros_like(u), np.array([rest]))
    np.testing.assert_allclose(found, expected[:, 0], rtol=TOLERANCE)


@pytest.mark.parametrize("gap", [0.0, 1e-3, 0.1234567, 0.999])
def test_of_a_stop_it_is_that_of_its_depth_whatever_its_damping(gap):
    """E = k u^2/2 + k_c (u - gap)^2/2: the force begins within the path, wherever that is."""
    table = np.array([[1.0, gap, 1e4, 5.0]])
    stop = Force(lambda width: (stop_force, None), np.array([[0]]), table)
    u = np.array([[-0.5], [0.05], [0.3], [1.0]])
    depth = np.maximum(u - gap, 0.0)
    velocity = np.full_like(u, 0.4)
    found = energy(one_mass(stop), u, velocity, np.zeros(1))
    expected = velocity**2 + 1.5 * u**2 + 5e3 * depth**2
    np.testing.assert_allclose(found, expected[:, 0], rtol=TOLERANCE)
