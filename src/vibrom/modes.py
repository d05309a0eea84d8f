"""Eigenmodes of a Term:  K phi = omega^2 M phi,  phi' M phi = 1, the largest entry positive.

Under a dead load they are those of small motions about the equilibrium that it makes: K is then the tangent there, pre-stress included.
"""

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.linalg import eigs, eigsh

from vibrom.solvers import static
from vibrom.term import SceneError, Term


def linearised(term: Term) -> tuple[np.ndarray, csr_matrix]:
    """The rest state (n,) [m] under the dead load and the stiffness (n, n) [N/m] about it; without one, zero and K itself."""
    if term.dead_load is None:
        return np.zeros(term.size), term.stiffness
    rest = static.equilibrium(term)
    return rest, csr_matrix(static.Body(term).tangent(rest))


def eigenmodes(term: Term, count: int) -> tuple[np.ndarray, np.ndarray]:
    """The `count` lowest angular frequencies (count,) [rad/s] and modes (count, n) [kg^-1/2].

    Shift-invert Lanczos about zero from a fixed start, so that the same scene gives the same bytes. Follower loads make K non-symmetric: as long as
    they let the body oscillate its modes are real, but not M-orthogonal (Arnoldi). A rest state that buckles or flutters has no eigenmodes.
    """
    for part, effect in (("mass", "inertia"), ("stiffness", "elasticity")):
        if getattr(term, part) is None:
            raise SceneError(f"effects has no {effect}, and without it there are no eigenmodes; list {effect}")
    size = term.mass.shape[0]
    start = np.ones(size) / np.sqrt(size)
    _, stiffness = linearised(term)
    symmetric = all(force.symmetric for force in term.forces)
    squares, vectors = (eigsh if symmetric else eigs)(stiffness.tocsc(), k=min(count, size - (1 if symmetric else 2)), M=term.mass.tocsc(), sigma=0.0, v0=start)
    # Rounding leaves a double eigenvalue imaginary parts of the order of the root of epsilon.
    if np.abs(squares.imag).max() > 1e-6 * np.abs(squares).max() or squares.real.min() <= 0.0:
        how = "buckles" if squares.real.min() <= 0.0 else "flutters"
        raise SceneError(f"effects: the body {how} under its dead load ({', '.join(f'{square:.3g}' for square in squares[:2])} = omega^2), so that it has no "
                         "modes to oscillate in; lower that load")
    squares, vectors = squares.real, vectors.real
    order = np.argsort(squares)
    modes = vectors[:, order].T
    modes /= np.sqrt(np.einsum("ki,ki->k", modes, (term.mass @ modes.T).T))[:, None]
    modes *= np.sign(modes[np.arange(len(modes)), np.abs(modes).argmax(axis=1)])[:, None]
    return np.sqrt(squares[order]), modes
