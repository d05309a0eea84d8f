"""A model from the equations whose motions are followed beyond where series converge."""

from dataclasses import replace

import numpy as np
import pytest
from scenes import THESIS, body
from scipy.sparse import block_diag

from vibrom import effects
from vibrom.bodies import space
from vibrom.methods.equations import Equations
from vibrom.models.training import MethodError, Training
from vibrom.models.trust import Residual, ellipse, equation_error
from vibrom.solvers.manifold import shooting
from vibrom.solvers.periodic import newmark_map


def fitted(term, **settings):
    return Equations(**settings).learn(Training((), term=term))


@pytest.fixture(scope="module")
def beam():
    return effects.assemble(space.build(body(cells=[10, 1])), THESIS)


@pytest.fixture(scope="module")
def rom(beam):
    return fitted(beam, order=9)


@pytest.fixture(scope="module")
def shot(beam):
    return fitted(beam, order=9, beyond="shooting")


@pytest.mark.parametrize("beyond", ["orbits", "shooting"])
def test_orbits_reach_farther_than_ratios(beam, rom, shot, beyond):
    """At the same large amplitude they obey the equations better, at small ones well enough."""
    farther = shot if beyond == "shooting" else fitted(beam, order=9, beyond=beyond)
    assert farther.reach[0] > rom.reach[0]
    residual, far = Residual(beam), ellipse(rom.reach, 0, 1.3)
    assert equation_error(residual, farther, far) < 0.5 * equation_error(residual, rom, far)
    assert equation_error(residual, farther, ellipse(rom.reach, 0, 0.3)) < 1e-3
    z = ellipse(rom.reach, 0, 0.8)
    pushed = [model.force_map(z, beam.load) / rom.reach for model in (rom, farther)]
    np.testing.assert_allclose(pushed[1], pushed[0], atol=0.02 * abs(pushed[0]).max())


def test_derivatives_by_few_modes_lead_to_the_same_motions(beam, shot, monkeypatch):
    """A body of many displacements costs no more columns than twice its modes. Steps are of other
    lengths then, and polynomials fitted to other motions of the family: both are trusted to 0.01.
    """
    columns, carried = [], newmark_map.carried
    assert beam.size > 30

    def counted(path, start, *rest):
        columns.append(start.shape[2])
        return carried(path, start, *rest)

    monkeypatch.setattr(shooting, "MODES", 12)
    monkeypatch.setattr(newmark_map, "carried", counted)
    few = fitted(beam, order=9, beyond="shooting")
    assert len(columns) > 5 and set(columns) == {2 * 12 + 2}
    np.testing.assert_allclose(few.reach, shot.reach, rtol=1e-2)
    z = ellipse(shot.reach, 0, 0.9)
    shape = shot.decode(z)
    np.testing.assert_allclose(few.decode(z), shape, rtol=0.0, atol=2e-3 * np.abs(shape).max())


@pytest.mark.parametrize("other", [{"style": "graph"}, {"force": "invariance"}, {"modes": (1, 2)}])
def test_orbits_are_those_of_one_mode_in_normal_form(other):
    with pytest.raises(MethodError, match="beyond: pade"):
        Equations(beyond="orbits", **other)


def test_a_large_body_is_not_shot(beam):
    large = replace(beam, mass=block_diag([beam.mass] * 50, format="csr"))
    with pytest.raises(MethodError, match="choose orbits"):
        fitted(large, beyond="shooting")
