"""How a load acts on the reduced positions of an autoencoder.

    decoder_mass   a = argmin |V a - M^-1 p|_M = (V'MV)^-1 V' p      the virtual work of the load
    decoder        a = argmin |V a - M^-1 p|   = (V'V)^-1 V' M^-1 p  (thesis, equation 2.16)
    encoder        a = w'(q) M^-1 p

V = dq/dz is the decoder's tangent at z, w' the encoder's at q = q(z). The acceleration M^-1 p that
the load gives to the free body is no motion of the model; the first two rules take the nearest one
that is. Nearest in the norm of the mass is what virtual work says, whatever the load. The Euclidean
norm and the encoder agree with it where p is nearly a multiple of M V, as a modal load is, and are
wrong by any factor where it is not: M^-1 p of a load at one node is an acceleration of that node
alone.

In network units V = s B v'(z) and p does the work s B'p. With R'R = s^2 B'MB, decoder_mass is the
Euclidean projection of R^-T s B'p on the tangents R v'(z).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.linalg import cholesky, solve_triangular
from scipy.sparse import csr_matrix
from scipy.sparse.linalg import splu

from vibrom.latent.coordinates import Coordinates

ForceRule = Literal["decoder_mass", "decoder", "encoder"]


@dataclass(frozen=True)
class Push:
    """A load in network units: the projections on A v'(z), or on the encoder, use nothing else."""

    load: np.ndarray  # (k,)
    weight: np.ndarray | None  # A (k, k); None: one


def push(rule: ForceRule, mass: csr_matrix, coordinates: Coordinates, p: np.ndarray) -> Push:
    """What the rule needs of the load p (n,)."""
    if rule != "decoder_mass":
        return Push(coordinates.reduce(splu(mass.tocsc()).solve(np.asarray(p, float))), None)
    basis = coordinates.directions(len(p))
    root = cholesky(basis.T @ (mass @ basis))
    return Push(solve_triangular(root, basis.T @ p, trans="T"), root)


def projected(tangents: np.ndarray, load: np.ndarray) -> np.ndarray:
    """The a (*batch, d) with the smallest |sum_i a_i t_i - load|, tangents (d, *batch, k)."""
    if len(tangents) == 1:
        tangent = tangents[0]
        return ((tangent @ load) / (tangent * tangent).sum(axis=-1))[..., None]
    gram = np.einsum("i...k,j...k->...ij", tangents, tangents)
    return np.linalg.solve(gram, np.moveaxis(tangents @ load, 0, -1)[..., None])[..., 0]
