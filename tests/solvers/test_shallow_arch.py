"""The backbone of a shallow arch, which softens, against beam theory: with w_0 the arch's shape,

    rho A w'' + E I w'''' = N (w_0'' + w'')'s,   N = E A int (w_0' w' + w'^2/2) dx

in clamped beams' modes, whose frequency at a small amplitude a of the first mode follows from
perturbation to second order: with a_ij the quadratic and b the cubic coefficients of the modes of
the arch,

    2 w_1 dw/a^2 = 3 b/4 + 2 sum_j a_11j (c_j + d_j/2),
    c_j = -a_11j/(2 w_j^2),   d_j = -a_11j/(2 (w_j^2 - 4 w_1^2))

(Nayfeh and Mook, Nonlinear Oscillations (1979), section 2.3, for one mode; the others answer the
square of the first).
"""

import numpy as np
import pytest
from scenes import SLENDER, body
from scipy.integrate import simpson
from scipy.optimize import brentq

from vibrom import effects
from vibrom.bodies import space
from vibrom.models.full_order import FullOrder
from vibrom.solvers.full.modes import eigenmodes
from vibrom.solvers.full.newmark import Newmark
from vibrom.solvers.manifold.parametrisation import parametrise
from vibrom.solvers.periodic.resonance import backbone

HEIGHT, RISE, WIDTH, DENSITY, YOUNG = 0.01, 0.016, 0.05, 440.0, SLENDER["young_modulus"]
EFFECTS = {
    "inertia": {"density": DENSITY},
    "elasticity": SLENDER,
    "geometric_nonlinearity": {},
    "rayleigh_damping": {"damping_ratio": 0.01},
    "modal_load": {"mode": 1},
}


def arch(columns):
    """The body of the scene `shallow_arch`, less Poisson's effect, and its term."""
    made = space.build(
        body(
            element="quadratic",
            cells=[columns, 1],
            clamped=["left", "right"],
            height=HEIGHT,
            rise=RISE,
            width=WIDTH,
        )
    )
    return made, effects.assemble(made, EFFECTS)


def symmetric_modes(count):
    """Of a clamped beam of length one, int phi^2 = 1: wave numbers k, int phi and int phi' phi'."""
    x, places = np.linspace(-0.5, 0.5, 8001), (np.arange(2 * count, step=2) + 1.5) * np.pi
    waves = [brentq(lambda k: np.cos(k) - 1 / np.cosh(k), p - 0.5, p + 0.5) for p in places]
    modes = []
    for k in waves:
        grows, falls = np.exp(k * (np.abs(x) - 0.5)), np.exp(-k * (np.abs(x) + 0.5))
        even, odd = (grows + falls, np.sign(x) * (grows - falls)) / (1.0 + np.exp(-k))
        phi = np.cos(k * x) / np.cos(k / 2) - even
        slope = -k * (np.sin(k * x) / np.cos(k / 2) + odd)
        modes.append(np.stack([phi, slope]) / np.sqrt(simpson(phi**2, x=x)))
    phi, slope = np.array(modes).transpose(1, 0, 2)
    return np.array(waves), simpson(phi, x=x), simpson(slope[:, None] * slope, x=x)


def softening():
    """w_1 [rad/s] and dw/a^2 [rad/s / (kg m^2)], a the mass-normalised amplitude."""
    waves, mean, stretch = symmetric_modes(9)
    stiff, g = YOUNG / DENSITY, 8.0 * RISE * mean  # w_0'' = -8 RISE
    squares, modes = np.linalg.eigh(
        np.diag(stiff * HEIGHT**2 / 12 * waves**4) + stiff * np.outer(g, g)
    )
    g, s = modes.T @ g, modes.T @ stretch @ modes
    quadratic = 0.5 * stiff * (g * s[0, 0] + 2.0 * g[0] * s[:, 0])
    cubic, first = 0.5 * stiff * s[0, 0] ** 2, squares[0]
    still, twice = -0.5 * quadratic / squares, -0.5 * quadratic / (squares - 4.0 * first)
    pull = 0.75 * cubic + 2.0 * np.sum(quadratic * (still + 0.5 * twice))
    return np.sqrt(first), pull / (2.0 * np.sqrt(first)) / (DENSITY * HEIGHT * WIDTH)


def of_series(term):
    """The same of the manifold: z' = z (lambda + g |z|^2), a = 2 |z|."""
    made = parametrise(term, (1,), 3)
    (place,) = made.monomials.index(np.array([[2, 1]]))
    return abs(made.masters.eigenvalues[0]), made.dynamics[0, place].imag / 4.0


def test_the_series_softens_as_beam_theory_has_it():
    frequency, slope = softening()
    ours = of_series(arch(20)[1])
    assert slope < 0.0
    assert ours[0] == pytest.approx(frequency, rel=2e-3)  # (k h)^2, what beam theory leaves out
    # Half as many elements change it by 4 %, so that these leave less than 1 %; thickness counts
    # some times, as what stretches and what bends nearly cancel.
    assert ours[1] == pytest.approx(slope, rel=0.015)


def test_the_full_orders_phase_resonance_is_that_of_the_series():
    """On a coarse mesh, with steps that lose (w h)^2/24 of any frequency alike."""
    made, term = arch(4)
    (frequency, shape), (_, slope) = (part[0] for part in eigenmodes(term, 1)), of_series(term)
    poles = np.array([-0.01 + 1j]) * frequency
    rest, probes = np.zeros(made.size), np.zeros(1, int)
    model = FullOrder(term, probes, Newmark(0.005), 100, "equilibrium", frequency, poles, rest)
    found = backbone(model.return_map(), 40.0, 4, 0.5)
    places, sizes = [], []
    for orbit in found.orbits:
        x, omega = found.problem.drive(orbit.point.x)
        motion = found.problem.flow.states(x, omega, orbit.p)[:, : made.size] @ (term.mass @ shape)
        places.append(omega)
        sizes.append(2.0 * abs(np.fft.rfft(motion)[1]) / len(motion))
    change = (places[-1] - places[0]) / (sizes[-1] ** 2 - sizes[0] ** 2)
    # w a^2 is a tenth of a thousandth of w here, of the next order in a^2 as little again.
    assert change == pytest.approx(slope, rel=2e-3)
