"""Systems for the tests of periodic motions: masses on springs with cubic ones to the ground, as
full order and as exact reduced models.

    M q'' + c M q' + K q + kappa q_1^3 e_1 = p a sin(Omega t)
"""

from dataclasses import replace

import numpy as np
from scipy.linalg import eigh
from scipy.sparse import csr_matrix

from vibrom.effects.cubic_spring import _force, _tangent
from vibrom.latent.polynomial_rom import PolynomialRom
from vibrom.models.full_order import FullOrder
from vibrom.models.reduced import Reduced
from vibrom.models.rollout import Integrator
from vibrom.solvers.full.newmark import Newmark
from vibrom.term import Force, Term


def _drag(damping, mass):
    """C, given itself or as a multiple of the mass."""
    return damping * mass if np.ndim(damping) == 0 else np.array(damping, float)


def term(mass, stiffness, load, cubic, damping):
    """`cubic` is the factor of q_i^3 on each displacement."""
    held = np.flatnonzero(cubic)
    spring = Force(
        lambda width: (_force, _tangent), held[:, None], np.array(cubic, float)[held][:, None]
    )
    mass, stiffness = csr_matrix(np.array(mass, float)), csr_matrix(np.array(stiffness, float))
    forces = (spring,) if len(held) else ()
    return Term(
        mass=mass,
        damping=csr_matrix(_drag(damping, mass.toarray())),
        stiffness=stiffness,
        load=np.array(load, float),
        forces=forces,
    )


def full_order(mass, stiffness, load, cubic, damping, steps=400, **newmark):
    """All displacements are watched."""
    made = term(mass, stiffness, load, cubic, damping)
    omega = np.sqrt(eigh(stiffness, mass, eigvals_only=True))
    ratio = damping / (2.0 * omega)
    root = np.sqrt(ratio.astype(complex) ** 2 - 1.0)
    poles = np.concatenate([omega * (-ratio + root), omega * (-ratio - root)])
    damped = omega[0] * np.sqrt(1.0 - ratio[0] ** 2)
    n = len(omega)
    return FullOrder(
        made, np.arange(n), Newmark(**newmark), steps, "equilibrium", damped, poles, np.zeros(n)
    )


def reduced(mass, stiffness, load, cubic, damping, reach=2.0):
    """The same system in its modes, all of them, in physical displacements where M = 1."""
    squares, vectors = eigh(stiffness, mass)
    modes, n = vectors.T, len(squares)
    linear = np.eye(2 * n, dtype=np.int64)
    # (sum_k phi_ki z_k)^3 by its monomials
    powers, factors = [], []
    for one in np.ndindex(*(n * (4,))):
        if sum(one) == 3:
            count = 6 / np.prod([[1, 1, 2, 6][e] for e in one])
            powers.append([*one, *([0] * n)])
            shapes = np.prod(modes ** np.array(one)[:, None], axis=0)  # (n,) at each displacement
            factors.append(-count * modes @ (np.array(cubic) * shapes))
    drift = np.zeros((2 * n, 2 * n + len(powers)))
    drift[:n, n : 2 * n] = np.eye(n)
    drag = modes @ _drag(damping, np.array(mass)) @ modes.T
    drift[n:, :n], drift[n:, n : 2 * n] = -np.diag(squares), -drag
    drift[n:, 2 * n :] = np.array(factors).T
    size = np.concatenate([np.full(n, reach), reach * np.sqrt(squares)])
    rom = PolynomialRom(
        size,
        modes @ mass,
        np.ones(2 * n),
        np.kron(np.eye(2), modes.T),
        linear,
        drift,
        np.concatenate([linear, np.array(powers)]),
        modes,
    )
    omega = np.sqrt(squares[0])
    damped = omega * np.sqrt(1.0 - (drag[0, 0] / (2.0 * omega)) ** 2)
    return Reduced(rom, np.array(load, float), np.arange(n), damped, Integrator())


def nonlinearly_damped(c1, c3, c5, cubic, reach):
    """x'' + c1 x' + c3 x'^3 + c5 x'^5 + x + cubic x^3 = a sin(Omega t), as a reduced model."""
    powers = np.array([[1, 0], [0, 1], [3, 0], [0, 3], [0, 5]])
    drift = np.array([[0.0, 1.0, 0.0, 0.0, 0.0], [-1.0, -c1, -cubic, -c3, -c5]])
    one, linear = np.eye(1), np.eye(2, dtype=np.int64)
    rom = PolynomialRom(np.full(2, reach), one, np.ones(2), np.eye(2), linear, drift, powers, one)
    return Reduced(rom, np.ones(1), np.array([0]), 1.0, Integrator())


def saddle(damping, cubic):
    """x'' + c x' - x + cubic x^3 = a sin(Omega t), as a reduced model, at rest in its saddle."""
    model = nonlinearly_damped(damping, 0.0, 0.0, cubic, 2.0)
    drift = model.rom.dynamics.copy()
    drift[1, 0] = 1.0
    return replace(model, rom=replace(model.rom, dynamics=drift))


def in_a_well(damping):
    """x'' + c x' + 2 x + 3 x^2 + x^3 = a sin(Omega t): at rest in one of two wells, the other one
    at x = -2, with a saddle between them.
    """
    model = nonlinearly_damped(damping, 0.0, 0.0, 1.0, 2.5)
    powers = np.array([[1, 0], [0, 1], [2, 0], [3, 0]])
    drift = np.array([[0.0, 1.0, 0.0, 0.0], [-2.0, -damping, -3.0, -1.0]])
    rom = replace(model.rom, dynamics=drift, dynamics_powers=powers)
    return replace(model, rom=rom, frequency=np.sqrt(2.0))


def one_to_two(coupling, damping):
    """x'' + 2 d x' + x = 2 e x y + a sin(Omega t),  y'' + 2 d y' + 4 y = e x^2,  as a reduced
    model of both.
    """
    powers = np.array([*np.eye(4, dtype=int), [1, 1, 0, 0], [2, 0, 0, 0]])
    drift = np.zeros((4, 6))
    drift[:2, 2:4], drift[2:, :2] = np.eye(2), -np.diag([1.0, 4.0])
    drift[2:, 2:4], drift[2, 4], drift[3, 5] = -2.0 * damping * np.eye(2), 2.0 * coupling, coupling
    linear, reach = np.eye(4, dtype=int), np.array([3.0, 1.5, 3.0, 3.0])
    rom = PolynomialRom(reach, np.eye(2), np.ones(4), np.eye(4), linear, drift, powers, np.eye(2))
    return Reduced(rom, np.array([1.0, 0.0]), np.arange(2), 1.0, Integrator())


DUFFING = {
    "mass": np.eye(1),
    "stiffness": np.eye(1),
    "load": [1.0],
    "cubic": [1.0],
    "damping": 0.04,
}
# A Duffing oscillator with a nonlinear tuned absorber, in the displacements x_1 and x_1 - x_2:
# example 02 of NLvib 1.3 (Krack and Gross, https://github.com/maltekrack/NLvib).
ABSORBER = {
    "mass": np.array([[1.05, -0.05], [-0.05, 0.05]]),
    "stiffness": np.diag([1.0, 0.0453]),
    "load": [1.0, 0.0],
    "cubic": [1.0, 0.0042],
    "damping": np.diag([0.002, 0.013]),
}
TWO = {
    "mass": np.diag([2.0, 1.0]),
    "stiffness": np.array([[3.0, -1.0], [-1.0, 1.0]]),
    "load": [0.0, 1.0],
    "cubic": [5.0, 0.0],
    "damping": 0.04,
}
