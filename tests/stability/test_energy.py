"""Energy of full-order states against the integral over the elements, and along an undamped motion."""

import numpy as np
import pytest
import skfem
from scenes import ELASTICITY, UNDAMPED, body
from skfem.helpers import ddot, grad, identity, trace

from vibrom import effects
from vibrom.bodies import space
from vibrom.models.energy import energy
from vibrom.solvers.full.modes import linearised
from vibrom.solvers.full.newmark import Newmark

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
