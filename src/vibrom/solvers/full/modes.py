"""Small motions about rest:  K phi = omega^2 M phi,  phi' M phi = 1, the largest entry positive.

Under a dead load they are motions about the equilibrium that it makes: K is then the tangent there,
pre-stress included. Entries of K are known to eps, and so a frequency is to

    eps |phi|' |K| |phi| / (2 omega^2 phi' M phi)

of itself: in slender bodies axial stiffness drowns the bending, as the fourth power of length over
height (2e-8 for a cantilever of 50, 0.003 for one of 1000, 0.04 for one of 2000). The energy of the
strains would tell the frequency without that loss (`tests/solvers/test_slender.py`), but the motion
is that of K q, rounded: a body that loses too much is refused, as its steps would be as wrong as
its modes. The rest state of a body is solved once, and so are its modes, however many effects and
steps need them: results are remembered for the last bodies.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from scipy.linalg import LinAlgError, cholesky_banded, eig, eigh
from scipy.sparse import csr_matrix
from scipy.sparse.linalg import ArpackError, LinearOperator, eigs, eigsh

from vibrom.kernels import banded
from vibrom.solvers.full import static
from vibrom.solvers.full.factors import factor, is_wide
from vibrom.term import SceneError, Term

LOOKED_AT = 10  # modes among which flutter is looked for
REMEMBERED = 8  # bodies
LOOSE = 1e-10  # of the largest stiffness: the force that rounding leaves on a body that none holds
LOST = 0.01  # of the first frequency: what rounding may take of it
FEW = 24  # displacements, up to which all modes are found at once
UNSOLVABLE = "the eigenmodes are beyond rounding"
BALANCE = "choose sizes and properties of the body that are not as many orders of magnitude apart"


class Linearised(NamedTuple):
    """A body at rest under its dead load. Shared by all who ask: read only."""

    rest: np.ndarray  # (n,) m; zero without a dead load
    stiffness: csr_matrix  # (n, n) N/m, about the rest state


class Modes(NamedTuple):
    """The lowest modes of small motions. Shared by all who ask: read only."""

    frequency: np.ndarray  # (modes,) rad/s
    shape: np.ndarray  # (modes, n) kg^-1/2


def linearised(term: Term) -> Linearised:
    """The rest state and the stiffness about it; without a dead load zero and K itself."""
    return _linearised(_Statics(term))


def eigenmodes(term: Term, count: int) -> Modes:
    """The `count` lowest modes.

    Shift-invert Lanczos about zero from a fixed start, so that the same scene gives the same bytes.
    Follower loads make K non-symmetric: its modes are real as long as it does not flutter, but not
    M-orthogonal (Arnoldi). A rest state that buckles or flutters has no eigenmodes: SceneError.
    """
    for part, effect in (("mass", "inertia"), ("stiffness", "elasticity")):
        if getattr(term, part) is None:
            raise SceneError(
                f"effects has no {effect}, and without it there are no eigenmodes; list {effect}"
            )
    if count < 1:
        raise ValueError(f"count = {count}; needed is at least one mode")
    try:
        with np.errstate(all="ignore"):  # what is no number is refused below
            found = _eigenmodes(_Statics(term), count)
    except (ArpackError, LinAlgError, RuntimeError) as error:
        _refuse_loose(term)
        raise SceneError(f"effects: {UNSOLVABLE} ({error}); {BALANCE}") from error
    if not all(np.isfinite(part).all() for part in found):
        raise SceneError(f"effects: {UNSOLVABLE} (overflow); {BALANCE}")
    return found


class _Statics:
    """A term, the same as another where all that bears on small motions is the same object."""

    def __init__(self, term: Term):
        self.term = term
        self.parts = (term.mass, term.stiffness, term.dead_load, *term.forces)

    def __hash__(self) -> int:
        return hash(tuple(map(id, self.parts)))

    def __eq__(self, other: object) -> bool:
        return (
            isinstance(other, _Statics)
            and len(self.parts) == len(other.parts)
            and all(mine is theirs for mine, theirs in zip(self.parts, other.parts))
        )


@lru_cache(REMEMBERED)
def _linearised(body: _Statics) -> Linearised:
    term = body.term
    if term.dead_load is None:
        rest, stiffness = np.zeros(term.size), term.stiffness
    else:
        rest = static.equilibrium(term)
        stiffness = csr_matrix(static.Body(term).tangent(rest))
    rest.flags.writeable = False
    return Linearised(rest, stiffness)


def _refuse_loose(term: Term) -> None:
    """Raises SceneError where a motion of all points along an axis meets no force."""
    if term.carried is None:
        return
    rigid = factor(term.mass.tocsc(), symmetric=True).solve(term.carried)
    pull = np.abs(term.stiffness @ rigid).max(axis=0)
    if (pull < LOOSE * abs(term.stiffness).max() * np.abs(rigid).max(axis=0)).any():
        raise SceneError(
            "body: nothing keeps it from moving as a whole, which is no vibration; name what is "
            "clamped (body.clamped), or hold it by springs"
        )


@lru_cache(REMEMBERED)
def _eigenmodes(body: _Statics, count: int) -> Modes:
    term, stiffness = body.term, _linearised(body).stiffness
    if all(force.symmetric for force in term.forces):
        squares, vectors, unstable = _symmetric(stiffness, term.mass, count)
    else:
        squares, vectors, unstable = _non_symmetric(stiffness, term.mass, count)
    lost = _rounding(stiffness, term.mass, squares, vectors)
    if lost > LOST:
        _refuse_loose(term)
        raise SceneError(
            f"body: rounding may change its first frequency by {lost:.2g} of itself (at most "
            f"{LOST:g} is let pass): it is too slender for its elements; take a thicker or shorter "
            "body, or fewer and longer elements"
        )
    if unstable:
        cause, cure = (
            ("its dead load", "lower that load")
            if term.dead_load is not None
            else ("a negative stiffness", "raise it, as cubic_spring.linear")
        )
        raise SceneError(
            f"effects: the body {unstable} under {cause}, so that it has no modes to oscillate in "
            f"about its rest state; {cure}"
        )
    order = np.argsort(squares)[:count]
    modes = vectors[:, order].T
    modes /= np.sqrt(np.einsum("ki,ki->k", modes, (term.mass @ modes.T).T))[:, None]
    modes *= np.sign(modes[np.arange(len(modes)), np.abs(modes).argmax(axis=1)])[:, None]
    frequency = np.sqrt(squares[order])
    frequency.flags.writeable = modes.flags.writeable = False
    return Modes(frequency, modes)


def _rounding(
    stiffness: csr_matrix, mass: csr_matrix, squares: np.ndarray, vectors: np.ndarray
) -> float:
    """How far rounding may move the lowest frequency, as a part of it; of a square of either sign,
    as rounding alone may make it negative.
    """
    first = np.abs(squares).argmin()
    phi = vectors[:, first]
    size = np.abs(phi) @ (abs(stiffness) @ np.abs(phi))
    kinetic = float(phi @ (mass @ phi))
    return float(np.finfo(float).eps * size / (2.0 * abs(squares[first]) * kinetic))


def _start(n: int) -> np.ndarray:
    return np.ones(n) / np.sqrt(n)


def _symmetric(
    stiffness: csr_matrix, mass: csr_matrix, count: int
) -> tuple[np.ndarray, np.ndarray, str]:
    """Squares of frequencies, modes by columns, and how the body is unstable."""
    n = mass.shape[0]
    if n <= FEW:
        squares, vectors = eigh(stiffness.toarray(), mass.toarray())
    else:
        inverse = None
        if is_wide(stiffness):
            solve = factor(stiffness.tocsc(), symmetric=True).solve
            inverse = LinearOperator((n, n), matvec=solve, dtype=float)
        squares, vectors = eigsh(
            stiffness.tocsc(),
            k=min(count, n - 1),
            M=mass.tocsc(),
            sigma=0.0,
            v0=_start(n),
            OPinv=inverse,
        )
    # Iteration about zero may miss a negative square that is far away; a factor does not.
    unstable = "" if _positive(stiffness) and squares.min() > 0.0 else "buckles"
    return squares, vectors, unstable


def _non_symmetric(
    stiffness: csr_matrix, mass: csr_matrix, count: int
) -> tuple[np.ndarray, np.ndarray, str]:
    """Squares of frequencies, modes by columns, and how the body is unstable."""
    n = mass.shape[0]
    if n <= FEW:
        squares, vectors = eig(stiffness.toarray(), mass.toarray())
    else:
        k = min(max(count, LOOKED_AT), n - 2)
        squares, vectors = eigs(stiffness.tocsc(), k=k, M=mass.tocsc(), sigma=0.0, v0=_start(n))
    unstable = ""
    if np.abs(squares.imag).max() > 1e-6 * np.abs(squares).max():
        unstable = "flutters"
    elif squares.real.min() <= 0.0:
        unstable = "buckles"
    return squares.real, vectors.real, unstable


def _positive(matrix: csr_matrix) -> bool:
    """Is a symmetric matrix positive definite, as far as rounding lets a factorisation tell?"""
    band = banded.to_band(matrix, banded.half_bandwidth(matrix))
    # Higham, Accuracy and Stability of Numerical Algorithms, theorem 10.7.
    band[:, 0] *= 1.0 + len(band) * np.finfo(float).eps
    try:
        cholesky_banded(band.T, lower=True)
    except LinAlgError:
        return False
    return True
