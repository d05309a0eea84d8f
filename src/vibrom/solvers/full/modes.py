"""Eigenmodes of a Term:  K phi = omega^2 M phi,  phi' M phi = 1, the largest entry positive.

Under a dead load they are those of small motions about the equilibrium that it makes: K is then the
tangent there, pre-stress included.
"""

import numpy as np
from scipy.linalg import LinAlgError, cholesky_banded
from scipy.sparse import csr_matrix
from scipy.sparse.linalg import eigs, eigsh

from vibrom.kernels import banded
from vibrom.solvers.full import static
from vibrom.term import SceneError, Term

LOOKED_AT = 10  # modes among which flutter is looked for


def linearised(term: Term) -> tuple[np.ndarray, csr_matrix]:
    """The rest state (n,) [m] under the dead load and the stiffness (n, n) [N/m] about it; without
    one, zero and K itself.
    """
    if term.dead_load is None:
        return np.zeros(term.size), term.stiffness
    rest = static.equilibrium(term)
    return rest, csr_matrix(static.Body(term).tangent(rest))


def eigenmodes(term: Term, count: int) -> tuple[np.ndarray, np.ndarray]:
    """The `count` lowest angular frequencies (count,) [rad/s] and modes (count, n) [kg^-1/2].

    Shift-invert Lanczos about zero from a fixed start, so that the same scene gives the same bytes.
    Follower loads make K non-symmetric: as long as they let the body oscillate its modes are real,
    but not M-orthogonal (Arnoldi). A rest state that buckles or flutters has no eigenmodes:
    SceneError.
    """
    for part, effect in (("mass", "inertia"), ("stiffness", "elasticity")):
        if getattr(term, part) is None:
            raise SceneError(
                f"effects has no {effect}, and without it there are no eigenmodes; list {effect}"
            )
    size = term.mass.shape[0]
    start = np.ones(size) / np.sqrt(size)
    _, stiffness = linearised(term)
    if all(force.symmetric for force in term.forces):
        squares, vectors = eigsh(
            stiffness.tocsc(), k=min(count, size - 1), M=term.mass.tocsc(), sigma=0.0, v0=start
        )
        # Iteration about zero may miss a negative square that is far away; a factor does not.
        unstable = "" if _positive(stiffness) and squares.min() > 0.0 else "buckles"
    else:
        squares, vectors = eigs(
            stiffness.tocsc(),
            k=min(max(count, LOOKED_AT), size - 2),
            M=term.mass.tocsc(),
            sigma=0.0,
            v0=start,
        )
        unstable = (
            "flutters"
            if np.abs(squares.imag).max() > 1e-6 * np.abs(squares).max()
            else "buckles"
            if squares.real.min() <= 0.0
            else ""
        )
        squares, vectors = squares.real, vectors.real
    if unstable:
        cause, cure = (
            ("its dead load", "lower that load")
            if term.dead_load is not None
            else ("a negative stiffness", "raise it, as cubic_spring.linear")
        )
        raise SceneError(
            f"effects: the body {unstable} under {cause}, so that it has no modes to oscillate in about its rest state; {cure}"
        )
    order = np.argsort(squares)[:count]
    modes = vectors[:, order].T
    modes /= np.sqrt(np.einsum("ki,ki->k", modes, (term.mass @ modes.T).T))[:, None]
    modes *= np.sign(modes[np.arange(len(modes)), np.abs(modes).argmax(axis=1)])[:, None]
    return np.sqrt(squares[order]), modes


def _positive(matrix: csr_matrix) -> bool:
    """Is a symmetric matrix positive definite, as far as rounding lets a factorisation tell?"""
    band = banded.to_band(matrix, banded.half_bandwidth(matrix))
    band[:, 0] *= (
        1.0 + len(band) * np.finfo(float).eps
    )  # Higham, Accuracy and Stability of Numerical Algorithms, theorem 10.7
    try:
        cholesky_banded(band.T, lower=True)
    except LinAlgError:
        return False
    return True
