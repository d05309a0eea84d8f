"""Eigenmodes of a Term:  K phi = omega^2 M phi,  phi' M phi = 1, the largest entry positive."""

import numpy as np
from scipy.sparse.linalg import eigsh

from vibrom.term import SceneError, Term


def eigenmodes(term: Term, count: int) -> tuple[np.ndarray, np.ndarray]:
    """The `count` lowest angular frequencies (count,) [rad/s] and modes (count, n) [kg^-1/2].

    Shift-invert Lanczos about zero from a fixed start, so that the same scene gives the same bytes.
    """
    for part, effect in (("mass", "inertia"), ("stiffness", "elasticity")):
        if getattr(term, part) is None:
            raise SceneError(f"effects has no {effect}, and without it there are no eigenmodes; list {effect}")
    size = term.mass.shape[0]
    start = np.ones(size) / np.sqrt(size)
    squares, vectors = eigsh(term.stiffness.tocsc(), k=min(count, size - 1), M=term.mass.tocsc(), sigma=0.0, v0=start)
    order = np.argsort(squares)
    modes = vectors[:, order].T
    modes /= np.sqrt(np.einsum("ki,ki->k", modes, (term.mass @ modes.T).T))[:, None]
    modes *= np.sign(modes[np.arange(len(modes)), np.abs(modes).argmax(axis=1)])[:, None]
    return np.sqrt(squares[order]), modes
