"""Slender bodies: frequencies agree with beam theory, or are refused with rounding's figure."""

import numpy as np
import pytest
from scenes import BEAM, quadratic_body
from scipy.sparse import csr_matrix, identity, kron
from scipy.sparse.linalg import splu

from vibrom import effects
from vibrom.bodies import space
from vibrom.solvers.full import modes
from vibrom.solvers.full.modes import eigenmodes
from vibrom.term import SceneError

CLAMPED_FREE = 1.8751040687  # beta L of the first mode


def first_frequency(ratio, cells=(20, 1)):
    made = space.build(quadratic_body(height=1.0 / ratio, cells=list(cells)))
    return eigenmodes(effects.assemble(made, BEAM), 1).frequency[0]


def theory(ratio):
    """(beta L)^2 sqrt(E I / (rho A)) / L^2 of a beam of length one."""
    return CLAMPED_FREE**2 * np.sqrt(104e9 / 440.0 / 12) / ratio


@pytest.mark.parametrize("ratio", [50, 200, 1000])
def test_what_is_not_refused_agrees_with_beam_theory(ratio):
    """Shear and rotary inertia lower it by (H/L)^2 at most, 4e-4; twenty elements, whose bending is
    of third degree, raise it by less than 1e-3; rounding moves it by up to 1 % more before it is
    refused, by 3e-3 at most here.
    """
    assert abs(first_frequency(ratio) / theory(ratio) - 1) < 1.5e-3


@pytest.mark.parametrize("cells", [(20, 1), (80, 1)])
@pytest.mark.parametrize("ratio", [2000, 5000, 20000])
def test_what_rounding_takes_is_refused_with_the_figure(ratio, cells):
    with pytest.raises(SceneError, match=r"rounding may change its first frequency by \d.*slender"):
        first_frequency(ratio, cells)


def of_strains(ratio, cells):
    """The first frequency from the energy of the strains, e = B q at every point, in which nothing
    cancels but what is exact to eps L/H: of a mode that is iterated with their forces, B' D e.
    """
    made = space.build(quadratic_body(height=1.0 / ratio, cells=list(cells)))
    term = effects.assemble(made, BEAM | {"geometric_nonlinearity": {}})
    (energy,) = term.forces[0].quartic()
    strain = (
        csr_matrix(kron(csr_matrix(energy.linear), identity(len(energy.weight)))) @ energy.local
    )

    def stress(q):
        e = (strain @ q).reshape(len(energy.moduli), -1)
        return e, energy.moduli @ e * energy.weight

    def force(q):
        return strain.T @ stress(q)[1].ravel()

    solve = splu(term.stiffness.tocsc()).solve
    mode = made.dof_location[:, 0] ** 2 * (made.dof_axis == 1)
    for _ in range(3):
        wanted = term.mass @ mode
        mode = solve(wanted)
        for _ in range(4):
            mode += solve(wanted - force(mode))
        mode /= np.sqrt(mode @ (term.mass @ mode))
    return np.sqrt(np.sum(np.multiply(*stress(mode))))


@pytest.mark.parametrize("ratio", [1000, 2000, 5000])
def test_the_bound_bounds_what_rounding_does(ratio, monkeypatch):
    """Against the frequency that the mesh has without rounding; meshes differ by rounding where
    elements are many, and the bound holds for each of them.
    """
    bounds, known = [], modes._rounding

    def noted(*given):
        bounds.append(known(*given))
        return 0.0

    monkeypatch.setattr(modes, "_rounding", noted)
    for cells in ((40, 1), (80, 1)):
        exact = of_strains(ratio, cells)
        assert abs(exact / theory(ratio) - 1) < 2e-4  # of forty elements
        assert abs(first_frequency(ratio, cells) / exact - 1) < bounds[-1]
        assert bounds[-1] > (0.01 if ratio > 1000 else 1e-3)
