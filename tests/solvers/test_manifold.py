"""Invariant manifolds against series found by hand, naive first-order sums and the laws of both."""

import itertools

import numpy as np
import pytest
from few_dofs import TWO_DAMPING, TWO_MASS, TWO_STIFFNESS, cubic_coupling, duffing, two, two_springs
from scenes import THESIS, UNDAMPED, body, quadratic_body

from vibrom import effects
from vibrom.bodies import space
from vibrom.models.energy import forces
from vibrom.solvers.full.modes import linearised
from vibrom.solvers.manifold.beside import beside
from vibrom.solvers.manifold.canonical import (
    action_coordinates,
    slopes,
    symplectic_form,
    symplectic_push,
)
from vibrom.solvers.manifold.covectors import carried, of_push
from vibrom.solvers.manifold.force import NoPolynomial, potentials
from vibrom.solvers.manifold.parametrisation import parametrise


def force_of(potential, q):
    """f(q) = B' w [(L + 2 Q(y, .))' D (L y + Q(y, y)) - L' D L y], one state."""
    y = (potential.local @ q).reshape(potential.linear.shape[1], -1)
    stretch = np.einsum("oij,ip,jp->op", potential.square, y, y)
    slope = potential.linear[:, :, None] + 2 * np.einsum("oij,ip->ojp", potential.square, y)
    straight = potential.linear @ y
    total = np.einsum("okp,op->kp", slope, potential.moduli @ (straight + stretch))
    total -= potential.linear.T @ potential.moduli @ straight
    return potential.local.T @ (potential.weight * total).ravel()


@pytest.mark.parametrize("element", ["bilinear", "quadratic"])
def test_a_potential_gives_the_force_of_the_kernels(element):
    made = space.build(body(element=element, cells=[3, 2]))
    spring = {"at": [1.0, 0.01], "direction": "y", "cubic": 3.0e5, "linear": 2.0}
    listed = {**UNDAMPED, "cubic_spring": spring}
    term = effects.assemble(made, listed)
    q = np.random.default_rng(0).normal(size=made.size) * 0.05
    expected, state = np.zeros((made.size, 1)), q[:, None].copy()
    for force in term.forces:
        force.kernels(1)[0](state, 0 * state, force.dofs, force.table, expected)
    found = sum(force_of(potential, q) for potential in potentials(term))
    np.testing.assert_allclose(found, expected[:, 0], rtol=1e-10, atol=1e-9 * abs(expected).max())


def test_a_stop_is_refused_by_name():
    stop = {"at": [1.0, 0.01], "direction": "y", "gap": 0.1, "stiffness": 5.0}
    term = effects.assemble(space.build(quadratic_body(cells=[2, 1])), {**UNDAMPED, "stop": stop})
    with pytest.raises(NoPolynomial, match="effects.stop"):
        parametrise(term, (1,), 3)


def frequencies(manifold):
    """Coefficients of g in z' = z g(|z|^2)."""
    count = (manifold.monomials.order + 1) // 2
    powers = np.array([[k + 1, k] for k in range(count)])
    return manifold.dynamics[0, manifold.monomials.index(powers)]


def test_duffing_has_the_backbone_of_its_birkhoff_normal_form():
    """E = J + 3/8 J^2 - 17/64 J^3, omega = dE/dJ, and the action J is 2 |z|^2."""
    term = duffing()
    manifold = parametrise(term, (1,), 7)
    action = action_coordinates(manifold, symplectic_form(manifold, term.mass))
    expected = [1j, 1.5j, -51j / 16, 375j / 32]
    np.testing.assert_allclose(frequencies(action)[:3], expected[:3], atol=1e-12)
    assert abs(frequencies(manifold)[1] - 1.5j) < 1e-12


def test_duffing_frequencies_are_those_of_its_elliptic_integral():
    from scipy.special import ellipk

    term = duffing()
    manifold = parametrise(term, (1,), 21)
    z = 0.12
    g = frequencies(manifold)
    omega = (g * z ** (2 * np.arange(len(g)))).sum().imag
    theta = np.linspace(0, 2 * np.pi, 4001)
    values = manifold.monomials.values(z * np.exp(1j * np.stack([theta, -theta], axis=1)))
    amplitude = (values @ manifold.displacement).real.max()
    square = amplitude**2
    exact = np.pi * np.sqrt(1 + square) / (2 * ellipk(square / (2 * (1 + square))))
    np.testing.assert_allclose(omega, exact, rtol=1e-9)


def test_damping_by_the_mass_decays_actions_at_its_own_rate():
    """Re g = -c/2 at every amplitude, and the symplectic form is constant."""
    term = two(0.06 * TWO_MASS)
    manifold = parametrise(term, (1,), 9)
    form = symplectic_form(manifold, term.mass)
    assert abs(form[0, 1, 1:]).max() > 0.1
    action = action_coordinates(manifold, form)
    g = frequencies(action)
    np.testing.assert_allclose(g.real, [-0.03, 0, 0, 0, 0], atol=1e-10 * abs(g).max())
    form = symplectic_form(action, term.mass)
    # Beyond the degree that the series hold, nothing is left of the form either.
    assert abs(form[0, 1, 1:]).max() < 1e-9 * abs(action.dynamics).max()


class Naive:
    """The first-order form  B x' = A x + F(x), B = [[C, M], [M, 0]], A = [[-K, 0], [0, M]], by sums
    over all pairs and triples of monomials and dense bordered solves; Jain and Haller (2022).
    """

    def __init__(self, term, potential, eigenvalues, order):
        m, c, k = (part.toarray() for part in (term.mass, term.damping, term.stiffness))
        zero = np.zeros_like(m)
        self.b, self.a = np.block([[c, m], [m, zero]]), np.block([[-k, zero], [zero, m]])
        self.potential, self.n, self.values = potential, len(m), eigenvalues
        right = [self._null(self.a - value * self.b) for value in eigenvalues]
        self.left = [self._null((self.a - value * self.b).T) for value in eigenvalues]
        self.w = {self._unit(i): right[i] for i in range(len(right))}
        self.r = {(i, self._unit(i)): eigenvalues[i] for i in range(len(right))}
        for degree in range(2, order + 1):
            for power in self._powers(degree):
                self._solve(power)

    def _null(self, matrix):
        return np.linalg.svd(matrix)[2][-1].conj()

    def _unit(self, i):
        return tuple(int(i == j) for j in range(len(self.values)))

    def _powers(self, degree):
        ranges = [range(degree + 1)] * len(self.values)
        return [p for p in itertools.product(*ranges) if sum(p) == degree]

    def _nonlinear(self, power):
        """F of this monomial: minus the force, by polarisation of its square and cubic parts."""
        p = self.potential
        total = np.zeros(2 * self.n, complex)
        known = {key: value[: self.n] for key, value in self.w.items()}

        def square(a, b):
            return np.einsum("oij,i,j->o", p.square, a, b)

        def turned(a, s):
            return 2 * np.einsum("oij,j,o->i", p.square, a, s)

        for one, a in known.items():
            for other, b in known.items():
                rest = tuple(x - y - z for x, y, z in zip(power, one, other))
                if not any(rest) and min(rest) >= 0:
                    total[: self.n] -= p.linear.T @ p.moduli @ square(a, b)
                    total[: self.n] -= turned(a, p.moduli @ p.linear @ b)
                elif min(rest) >= 0 and rest in known:
                    total[: self.n] -= turned(a, p.moduli @ square(b, known[rest]))
        return total

    def _solve(self, power):
        s = sum(e * value for e, value in zip(power, self.values))
        right = self._nonlinear(power)
        for (i, of_rate), rate in self.r.items():
            if sum(of_rate) < 2:
                continue
            source = tuple(x - y + (j == i) for j, (x, y) in enumerate(zip(power, of_rate)))
            if min(source) >= 0 and source in self.w and sum(source) > 1:
                right = right - source[i] * rate * (self.b @ self.w[source])
        held = [i for i, v in enumerate(self.values) if abs(s.imag - v.imag) < 0.1 * abs(v)]
        size, k = 2 * self.n, len(held)
        big = np.zeros((size + k, size + k), complex)
        big[:size, :size] = s * self.b - self.a
        for place, i in enumerate(held):
            big[:size, size + place] = self.b @ self.w[self._unit(i)]
            big[size + place, :size] = self.left[i] @ self.b
        found = np.linalg.solve(big, np.append(right, np.zeros(k)))
        self.w[power] = found[:size]
        for place, i in enumerate(held):
            self.r[(i, power)] = found[size + place]


@pytest.mark.parametrize("modes", [(1,), (2,), (1, 2)])
def test_general_damping_agrees_with_the_first_order_form(modes):
    """Eigenvectors differ by a factor, and a monomial by the product of its factors."""
    manifold = parametrise(two(), modes, 5)
    values = manifold.masters.eigenvalues
    np.testing.assert_allclose(
        np.linalg.det(values[0] ** 2 * TWO_MASS + values[0] * TWO_DAMPING + TWO_STIFFNESS),
        0.0,
        atol=1e-12,
    )
    naive = Naive(two(), two_springs(), values, 5)
    factor = [
        manifold.masters.shapes[i, 0] / naive.w[naive._unit(i)][0] for i in range(len(values))
    ]
    for k, power in enumerate(map(tuple, manifold.monomials.powers.tolist())):
        weight = np.prod(np.array(factor) ** np.array(power))
        state = np.concatenate([manifold.displacement[k], manifold.velocity[k]])
        np.testing.assert_allclose(state, weight * naive.w[power], rtol=1e-8, atol=1e-10)
        for i in range(len(values)):
            rate = naive.r.get((i, power), 0.0) * weight / factor[i]
            np.testing.assert_allclose(manifold.dynamics[i, k], rate, rtol=1e-8, atol=1e-10)


def error_of(term, manifold, amplitude):
    """|M DV R + C V + K W + f(W)| and |DW R - V| on some circles, at rest q_0."""
    rest, _ = linearised(term)
    d = len(manifold.masters.eigenvalues) // 2
    angles = np.random.default_rng(1).uniform(0, 2 * np.pi, (40, d))
    half = amplitude * np.exp(1j * angles)
    z = np.concatenate([half, half.conj()], axis=1)
    values, monomials = manifold.monomials.values(z), manifold.monomials
    q, v = (values @ part for part in (manifold.displacement, manifold.velocity))
    rate, dq, dv = values @ manifold.dynamics.T, 0.0, 0.0
    padded = np.concatenate([np.ones((len(z), 1)), values], axis=1)
    for i in range(2 * d):
        slope = monomials.powers[:, i] * padded[:, monomials.lowered[i] + 1]
        slope = np.where(monomials.powers[:, i] > 0, slope, 0.0) * rate[:, [i]]
        dq, dv = dq + slope @ manifold.displacement, dv + slope @ manifold.velocity
    assert max(abs(part.imag).max() for part in (q, v, dv)) < 1e-10 * abs(v).max()
    states = np.column_stack([rest, rest[:, None] + q.real.T])
    internal = term.stiffness @ states + forces(term, states)
    damping = 0.0 if term.damping is None else term.damping @ v.real.T
    residual = term.mass @ dv.real.T + damping + internal[:, 1:] - internal[:, :1]
    return abs(residual).max(), abs(dq - v).max()


GRAVITY = {"x": 0.0, "y": -300.0}
BEAMS = {
    "normal form": (THESIS, (1,), "normal_form"),
    "graph": (THESIS, (1,), "graph"),
    "stiffness damping": (
        {**UNDAMPED, "rayleigh_damping": {"damping_ratio": 0.02, "stiffness_factor": 2e-5}},
        (1,),
        "normal_form",
    ),
    "two modes": (THESIS, (1, 2), "normal_form"),
    "dead load": (
        {
            "inertia": THESIS["inertia"],
            "elasticity": THESIS["elasticity"],
            "geometric_nonlinearity": {},
            "gravity": GRAVITY,
            "rayleigh_damping": {"damping_ratio": 0.01},
        },
        (1,),
        "normal_form",
    ),
    "follower load": (
        {**THESIS, "follower_load": {"edge": "right", "pressure": 2.0e5, "shear": 1.0e5}},
        (1,),
        "normal_form",
    ),
}


@pytest.mark.parametrize("case", BEAMS)
@pytest.mark.parametrize("order", [3, 4, 6])
def test_the_residual_falls_with_the_order(case, order):
    """The first degree that is left out is order + 1."""
    listed, modes, style = BEAMS[case]
    term = effects.assemble(space.build(body(cells=[6, 1])), listed)
    manifold = parametrise(term, modes, order, style)
    amplitude = 0.03 / len(modes)
    errors = np.array([error_of(term, manifold, part * amplitude) for part in (1.0, 0.5)])
    slope = np.log2(errors[0] / errors[1])
    # Symmetric bodies skip a degree; the kinematic part may vanish to rounding.
    assert slope[0] > order + 0.7
    assert slope[1] > order + 0.7 or errors[0, 1] < 1e-9


def test_coefficients_of_the_thesis_beam():
    """Of an independent program of 80 lines, dense and in numpy (normal form, orders 3 to 9)."""
    term = effects.assemble(space.build(body()), THESIS)
    g = frequencies(parametrise(term, (1,), 9))
    expected = [
        -3.98052409 + 398.03250559j,
        41.6703514536 + 273.026773408j,
        539.298732318 + 1548.03937337j,
        9479.67387550 + 20329.8000282j,
        200593.131622 + 305865.045885j,
    ]
    np.testing.assert_allclose(g, expected, rtol=1e-6)


def test_two_frequencies_near_one_to_three_keep_their_exchange():
    """z_2' has z_1^3, and z_1' has z_2 z_1*^2, of size that a hand calculation gives: for
    u_1'' + u_1 + f_1 = 0 and u_2'' + w^2 u_2 + f_2 = 0 with U = u_1^3 u_2/3,  R = -f/(2 i w) of
    the resonant term.
    """
    w = 3.02
    term = cubic_coupling(w**2)
    manifold = parametrise(term, (1, 2), 3)
    # z_1, z_2, and their conjugates z_3, z_4; phi are the unit vectors
    signs = np.sign(manifold.masters.shapes[[0, 1], [0, 1]].real)
    place = manifold.monomials.index(np.array([[3, 0, 0, 0], [0, 1, 2, 0]]))
    # f_2 = u_1^3/3 has z_1^3/3; f_1 = u_1^2 u_2 has z_1*^2 z_2
    expected = [-(1 / 3) / (2j * w), -1 / 2j]
    found = [manifold.dynamics[1, place[0]], manifold.dynamics[0, place[1]]]
    np.testing.assert_allclose(np.array(found) * signs.prod(), expected, rtol=0.03)
    narrow = parametrise(term, (1, 2), 3, detuning=0.001)
    assert narrow.dynamics[1, place[0]] == 0.0


def test_a_heavily_damped_oscillator_has_two_real_eigenvalues():
    manifold = parametrise(duffing(c=3.0), (1,), 5)
    values = manifold.masters.eigenvalues
    np.testing.assert_allclose(np.sort(values), [-1.5 - np.sqrt(1.25), -1.5 + np.sqrt(1.25)])
    # Invariance of u'' + 3 u' + u + u^3 = 0 at a state
    z = np.array([[0.02, -0.03]])
    series, rate = manifold.monomials.values(z), None
    q = (series @ manifold.displacement).real[0, 0]
    rate = series @ manifold.dynamics.T
    step = 1e-6
    ahead = manifold.monomials.values(z + step * rate) @ manifold.velocity
    behind = manifold.monomials.values(z - step * rate) @ manifold.velocity
    a = ((ahead - behind) / (2 * step)).real[0, 0]
    v = (series @ manifold.velocity).real[0, 0]
    assert abs(a + 3 * v + q + q**3) < 1e-8


@pytest.mark.parametrize("modes", [(1,), (1, 2)])
def test_a_load_pushes_along_the_manifold_symplectically(modes):
    """sum_j Omega_ij S_j = d_i W' p at a state, all evaluated directly."""
    term = two(0.06 * TWO_MASS)
    manifold = parametrise(term, modes, 7)
    push = symplectic_push(manifold, symplectic_form(manifold, term.mass))
    d = len(modes)
    half = 0.05 * np.exp(1j * np.arange(1, d + 1))
    z = np.concatenate([half, half.conj()])
    values, step = manifold.monomials.values(z), 1e-6
    slopes = [
        (manifold.monomials.values(z + step * e) - manifold.monomials.values(z - step * e))
        / (2 * step)
        for e in np.eye(2 * d)
    ]
    dq, dv = (
        np.array([slope @ part for slope in slopes])
        for part in (manifold.displacement, manifold.velocity)
    )
    omega = dq @ TWO_MASS @ dv.T - dv @ TWO_MASS @ dq.T
    found = push[:, 0] + np.einsum("l,iln->in", values, push[:, 1:])
    np.testing.assert_allclose(omega @ found, dq, atol=1e-6)


def test_the_push_is_real_in_real_coordinates():
    term = two()
    manifold = parametrise(term, (1, 2), 5)
    push = symplectic_push(manifold, symplectic_form(manifold, term.mass))
    mirror = list(manifold.masters.mirror)
    np.testing.assert_allclose(
        push[:, 1:][:, manifold.monomials.conjugate], push[mirror][:, 1:].conj(), atol=1e-12
    )


def moving(manifold, series, z):
    """A series (1 + l, ...), the constant first, at the states z (m, 2d)."""
    values = np.pad(manifold.monomials.values(z), ((0, 0), (1, 0)), constant_values=1.0)
    return np.tensordot(values, series, 1)


@pytest.mark.parametrize("modes", [(1,), (1, 2)])
def test_covectors_of_the_equations_are_those_of_the_symplectic_form(modes):
    """Where damping is by the mass; in any coordinates."""
    term = two(0.06 * TWO_MASS)
    manifold = parametrise(term, modes, 7)
    known = of_push(manifold, symplectic_push(manifold, symplectic_form(manifold, term.mass)))
    found = carried(manifold)
    np.testing.assert_allclose(found.y, known.y, atol=1e-9 * abs(known.y).max())
    np.testing.assert_allclose(found.x, known.x, atol=1e-9 * abs(known.x).max())


@pytest.mark.parametrize("modes", [(1,), (1, 2)])
def test_covectors_are_dual_to_the_tangents(modes):
    """Y_i B d_j W = delta_ij at a state, of any damping, to the order of the series."""
    manifold = parametrise(two(), modes, 9)
    covectors, d = carried(manifold), len(modes)
    half = 0.03 * np.exp(1j * np.arange(1, d + 1))[None]
    z = np.concatenate([half, half.conj()], axis=1)
    y, x = (
        np.stack([moving(manifold, row, z)[0] for row in part])
        for part in (covectors.y, covectors.x)
    )
    q, v = (
        np.stack([moving(manifold, row, z)[0] for row in slopes(manifold.monomials, part)])
        for part in (manifold.displacement, manifold.velocity)
    )
    found = y @ (TWO_DAMPING @ q.T + TWO_MASS @ v.T) + x @ TWO_MASS @ q.T
    np.testing.assert_allclose(found, np.eye(2 * d), atol=1e-9)


@pytest.mark.parametrize("damping", [TWO_DAMPING, 0.06 * TWO_MASS])
def test_what_is_beside_obeys_the_linearised_equations(damping):
    """x = X(z) e^(i Omega t), z' = R(z):  M x'' + C x' + (K + df/dq) x = p e^(i Omega t) less what
    moving z makes of the push S e^(i Omega t), at a state, by differences in time.
    """
    term, omega, load = two(damping), 1.1, np.array([0.3, 1.0])
    manifold = parametrise(term, (1,), 11)
    covectors = carried(manifold)
    shape, push = beside(manifold, covectors, load, omega), covectors.y @ load
    z0, step = 0.04 * np.exp(0.7j), 1e-4

    def rate(t, z, size):
        """z' with the push, times a small number."""
        pair = np.array([[z, np.conj(z)]])
        signal = np.exp(1j * omega * t)
        free = manifold.monomials.values(pair)[0] @ manifold.dynamics[0]
        # A complex load moves z_1 and z_2 apart; its real part is taken here.
        s = moving(manifold, push[0][:, None], pair)[0, 0]
        return free + size * s * signal.real

    def path(t, size):
        z, h, now = z0, t / 40, 0.0
        for _ in range(40):
            k1 = rate(now, z, size)
            k2 = rate(now + h / 2, z + h / 2 * k1, size)
            k3 = rate(now + h / 2, z + h / 2 * k2, size)
            k4 = rate(now + h, z + h * k3, size)
            z, now = z + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4), now + h
        return z

    def displacement(t, size):
        z = path(t, size)
        pair = np.array([[z, np.conj(z)]])
        own = (manifold.monomials.values(pair) @ manifold.displacement)[0].real
        # cos(Omega t) = Re e^(i Omega t), of which X has the response
        return own + size * (moving(manifold, shape, pair)[0] * np.exp(1j * omega * t)).real

    def residual(size):
        h = 100 * step
        back, here, ahead = (displacement(t, size) for t in (-h, 0.0, h))
        two_back, two_ahead = displacement(-2 * h, size), displacement(2 * h, size)
        v = (8 * (ahead - back) - (two_ahead - two_back)) / (12 * h)
        a = (16 * (ahead + back) - (two_ahead + two_back) - 30 * here) / (12 * h**2)
        force = TWO_STIFFNESS @ here + force_of(two_springs(), here)
        return TWO_MASS @ a + damping @ v + force - size * load

    size = 1e-4
    first_order = (residual(size) - residual(-size)) / (2 * size)
    assert abs(first_order).max() < 1e-6 * abs(load).max()
