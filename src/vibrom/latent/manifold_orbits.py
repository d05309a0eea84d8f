"""From a model of ratios, as far as it holds, to one of polynomials over farther motions.

Inside, motions are those of the model; beyond they are periodic motions of the undamped body,
followed in their action (`solvers.manifold.orbits`). Polynomials in z of the order of the series
are fitted to all of them by least squares, and the load pushes by the symplectic form, which is
constant in the coordinates of the action:  S = J d(W' p)/dz.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from vibrom.latent.manifold_rom import ManifoldRom
from vibrom.latent.manifold_series import ManifoldSeries
from vibrom.solvers.full.modes import linearised
from vibrom.solvers.manifold.canonical import symplectic_form, symplectic_push
from vibrom.solvers.manifold.orbits import Family, Orbits, fitted, follow
from vibrom.term import Term

HARMONICS = 12  # more of them meet higher frequencies of slender beams sooner
MORE = 4  # degrees than the series have
INSIDE = 0.5  # of what the model is trusted to
COUNT = 20  # motions inside; beyond, as close to one another
FARTHEST = 1.6  # times what the model is trusted to


def followed(series: ManifoldSeries, model: ManifoldRom, term: Term) -> ManifoldSeries:
    """The series of farther motions; `model` is one of these series, with the reach to which it is
    trusted.
    """
    amplitude = 0.5 * model.reach[0]  # |z|
    step = INSIDE * amplitude / COUNT
    inside = orbits_of(model, series, step * np.arange(1, COUNT + 1))
    rest, _ = linearised(term)
    family = Family(term, rest, series.basis, HARMONICS)
    beyond = follow(family, inside, step, FARTHEST * amplitude)
    order = series.manifold.monomials.order + MORE
    manifold = fitted(series.manifold, series.basis, inside.joined(beyond), order)
    form = np.zeros((2, 2, 1 + len(manifold.monomials)), complex)
    form[:, :, 0] = symplectic_form(series.manifold, term.mass)[:, :, 0]
    return replace(series, manifold=manifold, push=symplectic_push(manifold, form))


def orbits_of(model: ManifoldRom, series: ManifoldSeries, amplitude: np.ndarray) -> Orbits:
    """The motions of a model at these |z| (m,)."""
    angle = 2.0 * np.pi * np.arange(2 * HARMONICS + 1) / (2 * HARMONICS + 1)
    z = amplitude[:, None] * np.exp(1j * angle)
    forward = series.coordinates.forward
    y = (np.stack([z, z.conj()], axis=-1) @ forward.T).real
    rate = (model.drift(y) @ np.linalg.inv(forward).T)[..., 0] / z
    return Orbits(amplitude**2, rate.mean(axis=1), model.displacement(y) @ series.basis)
