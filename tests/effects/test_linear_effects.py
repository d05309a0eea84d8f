"""Mass, stiffness, damping and modal load against closed forms."""

import numpy as np
import pytest
from scenes import CANTILEVER, LINEAR, THESIS, body, quadratic_body

from vibrom import effects
from vibrom.bodies import space
from vibrom.solvers.full.modes import eigenmodes
from vibrom.term import SceneError


def test_mass_weighs_what_the_body_weighs():
    made = space.build(body(clamped=[]))
    term = effects.assemble(made, {"inertia": {"density": 440.0}})
    push = (made.dof_axis == 0).astype(float)
    assert push @ (term.mass @ push) == pytest.approx(440.0 * 1.0 * 0.02 * 0.05, rel=1e-12)


def test_first_frequencies_of_the_thesis():
    made = space.build(CANTILEVER)
    frequency, modes = eigenmodes(effects.assemble(made, LINEAR), 4)
    # Printed to seven digits; the first to +-0.001 rad/s.
    assert frequency[0] == pytest.approx(398.0524, abs=1e-3)
    np.testing.assert_allclose(frequency, [398.0524, 2492.166, 6971.105, 13644.66], rtol=1e-6)
    assert modes[0][made.probes["tip"]] == pytest.approx(3.0150, abs=1e-4)
    assert modes[0][made.probes["probe"]] == pytest.approx(1.1121, abs=1e-4)


def test_quadratic_elements_do_not_lock():
    """Euler-Bernoulli: omega_1 = 1.8751^2 sqrt(EI / (rho A L^4)); shear and rotary inertia lower a
    beam of slenderness 50 by about 0.05 %, and the clamped edge, which stops the contraction across
    it, raises it by about as much."""
    frequency, _ = eigenmodes(effects.assemble(space.build(quadratic_body()), LINEAR), 1)
    inertia, area = 0.05 * 0.02**3 / 12, 0.05 * 0.02
    beam = 1.8751040687**2 * np.sqrt(104e9 * inertia / (440.0 * area))
    assert frequency[0] == pytest.approx(beam, rel=2e-3)
    assert frequency[0] == pytest.approx(312.2, abs=0.1)


def test_static_deflection_under_an_end_load():
    """Euler-Bernoulli: w = F L^3 / (3 E I), within the shear and end effects of slenderness 50."""
    made = space.build(quadratic_body(probes={"tip": {"at": [1.0, 0.01], "direction": "y"}}))
    stiffness = effects.assemble(made, LINEAR).stiffness
    at_end = np.isclose(made.dof_location[:, 0], 1.0) & (made.dof_axis == 1)
    load = np.where(at_end, 1.0 / at_end.sum(), 0.0)
    from scipy.sparse.linalg import spsolve

    expected = 1.0 / (3 * 104e9 * 0.05 * 0.02**3 / 12)
    assert spsolve(stiffness.tocsc(), load)[made.probes["tip"]] == pytest.approx(expected, rel=2e-3)


def test_damping_ratio_of_the_first_mode():
    made = space.build(CANTILEVER)
    term = effects.assemble(
        made, {**THESIS, "rayleigh_damping": {"damping_ratio": 0.02, "stiffness_factor": 1e-5}}
    )
    frequency, modes = eigenmodes(term, 2)
    ratios = [mode @ (term.damping @ mode) / (2 * omega) for omega, mode in zip(frequency, modes)]
    # The stiffness part adds b omega/2, the mass part what the first mode then lacks.
    second = (2 * 0.02 * frequency[0] - 1e-5 * frequency[0] ** 2) / (
        2 * frequency[1]
    ) + 1e-5 * frequency[1] / 2
    np.testing.assert_allclose(ratios, [0.02, second], rtol=1e-9)


def test_modal_load_drives_one_mode():
    made = space.build(CANTILEVER)
    term = effects.assemble(made, THESIS)
    _, modes = eigenmodes(term, 3)
    np.testing.assert_allclose(modes @ term.load, [1.0, 0.0, 0.0], atol=1e-9)


def test_a_scene_without_an_effect_has_no_trace_of_it():
    term = effects.assemble(space.build(body()), {"inertia": {"density": 1.0}})
    assert (term.damping, term.stiffness, term.load, term.forces) == (None, None, None, ())


def test_probe_off_the_mesh_is_refused():
    with pytest.raises(SceneError, match=r"body.probes.tip.at = \[0.51, 0.0\] is no node"):
        space.build(body(probes={"tip": {"at": [0.51, 0.0], "direction": "y"}}))


def test_a_mode_that_the_body_has_not_is_refused():
    made = space.build(body(cells=[2, 1]))
    with pytest.raises(
        SceneError, match="effects.modal_load.mode = 500 is no mode of this body; choose 1 to 7"
    ):
        effects.assemble(made, {**LINEAR, "modal_load": {"mode": 500}})


def test_no_modes_without_inertia():
    made = space.build(body(cells=[2, 1]))
    with pytest.raises(SceneError, match="effects has no inertia"):
        eigenmodes(effects.assemble(made, {"elasticity": LINEAR["elasticity"]}), 1)


@pytest.mark.parametrize("element", ["bilinear", "quadratic"])
@pytest.mark.parametrize("more", [{}, {"gravity": {}}])
def test_a_body_that_nothing_holds_is_one_line(element, more):
    """Its three rigid motions are no vibrations, and no reduced model is made about them."""
    made = space.build(body(element=element, cells=[4, 1], height=0.1, clamped=[]))
    with pytest.raises(SceneError, match="nothing keeps it from moving as a whole"):
        eigenmodes(effects.assemble(made, {**LINEAR, **more}), 3)
