"""Response curves of a beam between two walls, which hardens, against the closed form of its
backbone:

    u'' + omega_0^2 (u + e u^3/r^2) = 0,   e = (int phi'^2)^2 / (2 int phi''^2),   r = h/sqrt(12)

of the deflection u phi(x) in the clamped beam's first mode, phi = 1 in the middle, with the tension
that its length asks for; its period is a complete elliptic integral.
"""

import numpy as np
import pytest
from scenes import SLENDER, quadratic_body
from scipy.integrate import simpson
from scipy.special import ellipk

from vibrom import effects
from vibrom.bodies import space
from vibrom.models.full_order import FullOrder
from vibrom.solvers.full.modes import eigenmodes
from vibrom.solvers.full.newmark import Newmark
from vibrom.solvers.periodic.continuation import Pace
from vibrom.solvers.periodic.equations import in_frequency
from vibrom.solvers.periodic.response import Span, response
from vibrom.solvers.periodic.stability import Kind

HEIGHT, FORCING, DAMPING = 0.02, 800.0, 0.01
EFFECTS = {
    "inertia": {"density": 440.0},
    "elasticity": SLENDER,
    "geometric_nonlinearity": {},
    "rayleigh_damping": {"damping_ratio": DAMPING},
    "modal_load": {"mode": 1},
}


@pytest.fixture(scope="module")
def clamped():
    """A coarse one; its frequency, and all its motions."""
    body = quadratic_body(
        cells=[6, 1],
        clamped=["left", "right"],
        probes={"middle": {"at": [0.5, 0.0], "direction": "y"}},
    )
    made = space.build(body)
    term = effects.assemble(made, EFFECTS)
    omega = eigenmodes(term, 1).frequency[0]
    rest, probe = np.zeros(made.size), made.probes["middle"]
    newmark, poles = Newmark(alpha=0.005), np.array([-DAMPING + 1j]) * omega
    model = FullOrder(
        term,
        np.array([probe]),
        newmark,
        100,
        "equilibrium",
        omega,
        poles,
        rest,
        place=made.dof_location,
        axis=made.dof_axis,
    )
    span = Span(1.0 * omega, 1.25 * omega, 100, 1e-3 * omega)
    flow = model.return_map()
    return omega, response(in_frequency(flow, FORCING), span, Pace(0.04 * omega, turn=0.35))


def backbone(amplitude):
    """omega/omega_0 at amplitudes [m] in the middle."""
    x = np.linspace(0.0, 1.0, 4001)
    k = 4.730040744862704
    ratio = (np.cosh(k) - np.cos(k)) / (np.sinh(k) - np.sin(k))
    phi = np.cosh(k * x) - np.cos(k * x) - ratio * (np.sinh(k * x) - np.sin(k * x))
    slope = k * (np.sinh(k * x) + np.sin(k * x) - ratio * (np.cosh(k * x) - np.cos(k * x)))
    bend = k**2 * (np.cosh(k * x) + np.cos(k * x) - ratio * (np.sinh(k * x) + np.sin(k * x)))
    top = phi[2000]
    stretch, bending = simpson(slope**2, x=x) / top**2, simpson(bend**2, x=x) / top**2
    e = stretch**2 / (2.0 * bending) * 12.0 * (amplitude / HEIGHT) ** 2
    return np.pi / (2.0 * ellipk(e / (2.0 * (1.0 + e)))) * np.sqrt(1.0 + e)


def test_the_peak_lies_on_the_backbone_in_closed_form(clamped):
    """Within half a percent of the frequency: the mode changes its shape as it swings."""
    omega, found = clamped
    heights = np.array([item.swing.displacement[0].max() for item in found])
    top = int(heights.argmax())
    assert heights[top] > 0.8 * HEIGHT  # the tension adds two fifths to the stiffness
    assert found[top].orbit.p / omega == pytest.approx(backbone(heights[top]), rel=5e-3)


def test_its_two_folds_are_named_and_bound_the_unstable_part(clamped):
    omega, found = clamped
    kinds = [item.orbit.kind for item in found]
    assert [kind for kind in kinds if kind != Kind.REGULAR] == [Kind.FOLD, Kind.FOLD, Kind.END]
    high, low = (place for place, kind in enumerate(kinds) if kind == Kind.FOLD)
    assert found[high].orbit.p > found[low].orbit.p + 0.05 * omega
    unstable = [np.abs(item.multipliers).max() > 1.0 for item in found]
    assert all(unstable[high + 1 : low]) and not any(unstable[:high] + unstable[low + 1 :])
