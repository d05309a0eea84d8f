"""Terms of one and two displacements whose forces are polynomials written down by hand."""

import numpy as np
from scipy.sparse import csr_matrix

from vibrom.term import Force, Quartic, Term

SPRING = Quartic(
    csr_matrix([[1.0]]), np.ones(1), np.zeros((1, 1)), np.ones((1, 1, 1)), np.array([[0.5]])
)  # U = u^4/4


def polynomial(potential, size):
    """A force whose kernels are not needed."""
    dofs = np.arange(size)[None]
    return Force(lambda width: (None, None), dofs, np.zeros((1, 1)), quartic=lambda: (potential,))


def oscillators(mass, damping, stiffness, potential):
    """A term of few displacements."""
    parts = [None if part is None else csr_matrix(part) for part in (mass, damping, stiffness)]
    return Term(*parts, forces=(polynomial(potential, len(stiffness)),))


def duffing(c=0.0, linear=1.0, cubic=1.0):
    """u'' + c u' + linear u + cubic u^3 = 0."""
    potential = Quartic(
        *(getattr(SPRING, name) for name in ("local", "weight", "linear", "square")),
        SPRING.moduli * cubic,
    )
    return oscillators(np.eye(1), c * np.eye(1), linear * np.eye(1), potential)


TWO_MASS = np.diag([2.0, 1.0])
TWO_STIFFNESS = np.array([[3.0, -1.0], [-1.0, 1.5]])
TWO_DAMPING = np.array([[0.06, -0.02], [-0.02, 0.09]])  # couples the modes


def two_springs():
    """Strains e = (u_1^2 + u_2/3, u_1 u_2), so that the force has square and cubic parts."""
    square = np.zeros((2, 2, 2))
    square[0, 0, 0], square[1, 0, 1], square[1, 1, 0] = 1.0, 0.5, 0.5
    linear = np.array([[0.0, 1 / 3], [0.0, 0.0]])
    return Quartic(csr_matrix(np.eye(2)), np.ones(1), linear, square, np.diag([1.5, 0.4]))


def two(damping=TWO_DAMPING):
    return oscillators(TWO_MASS, damping, TWO_STIFFNESS, two_springs())


def cubic_coupling(square_of_second):
    """u_1'' + u_1 + dU/du_1 = 0,  u_2'' + w^2 u_2 + dU/du_2 = 0,  U = u_1^3 u_2/3 = e_1 e_2/3."""
    square = np.zeros((2, 2, 2))
    square[0, 0, 0], square[1, 0, 1], square[1, 1, 0] = 1.0, 0.5, 0.5
    moduli = np.array([[0.0, 1 / 3], [1 / 3, 0.0]])  # of e = (u_1^2, u_1 u_2)
    potential = Quartic(csr_matrix(np.eye(2)), np.ones(1), np.zeros((2, 2)), square, moduli)
    return oscillators(np.eye(2), None, np.diag([1.0, square_of_second]), potential)


def square_coupling(square_of_second):
    """u_1'' + u_1 + dU/du_1 = 0,  u_2'' + w^2 u_2 + dU/du_2 = 0,  U = u_1^2 u_2/4 = e_1 e_2/4."""
    square, linear = np.zeros((2, 2, 2)), np.array([[0.0, 0.0], [0.0, 1.0]])
    square[0, 0, 0] = 1.0
    moduli = np.array([[0.0, 0.25], [0.25, 0.0]])  # of e = (u_1^2, u_2)
    potential = Quartic(csr_matrix(np.eye(2)), np.ones(1), linear, square, moduli)
    return oscillators(np.eye(2), None, np.diag([1.0, square_of_second]), potential)
