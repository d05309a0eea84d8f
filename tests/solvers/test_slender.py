"""Slender bodies: frequencies agree with beam theory, or are refused with rounding's figure."""

import numpy as np
import pytest
from scenes import BEAM, quadratic_body

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


@pytest.mark.parametrize("ratio", [1000, 2000, 5000])
def test_the_bound_bounds_what_rounding_does(ratio, monkeypatch):
    """Meshes differ by rounding where elements are many, and the bound holds for each of them."""
    bounds, known = [], modes._rounding

    def noted(*given):
        bounds.append(known(*given))
        return 0.0

    monkeypatch.setattr(modes, "_rounding", noted)
    for cells in ((40, 1), (80, 1)):
        away = abs(first_frequency(ratio, cells) / theory(ratio) - 1)
        assert away < bounds[-1] + 2e-4  # of forty elements
        assert bounds[-1] > (0.01 if ratio > 1000 else 1e-3)
