"""From a model of ratios, as far as it holds, to one of polynomials over farther motions.

Inside, motions are those of the model; beyond they are periodic motions of the undamped body,
followed in their action, with few harmonics in few directions (`solvers.manifold.orbits`) or by
shooting (`solvers.manifold.shooting`). Polynomials in z of the order of the series
are fitted to all of them by least squares, and the load pushes by the symplectic form, which is
constant in the coordinates of the action:  S = J d(W' p)/dz.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Literal

import numpy as np

from vibrom.latent.manifold_rom import ManifoldRom
from vibrom.latent.manifold_series import ManifoldSeries
from vibrom.solvers.full.modes import linearised
from vibrom.solvers.manifold.canonical import symplectic_form, symplectic_push
from vibrom.solvers.manifold.orbits import Family, Orbits, fitted, follow
from vibrom.solvers.manifold.shooting import shoot
from vibrom.term import Term

# More of the first meet higher frequencies of slender beams sooner; shooting passes them.
HARMONICS = {"orbits": 12, "shooting": 20}
MORE = 4  # degrees than the series have
INSIDE = 0.5  # of what the model is trusted to
COUNT = 20  # motions inside; beyond, as close to one another
# Times what the model is trusted to; the smaller ones are for polynomials that do not follow.
FARTHEST = {"orbits": (1.6,), "shooting": (1.8, 1.6, 1.4)}


def followed(
    series: ManifoldSeries, model: ManifoldRom, term: Term, how: Literal["orbits", "shooting"]
) -> Iterator[ManifoldSeries]:
    """The series of farther motions, the farthest first; `model` is one of these series, with the
    reach to which it is trusted.
    """
    amplitude = 0.5 * model.reach[0]  # |z|
    step = INSIDE * amplitude / COUNT
    inside = orbits_of(model, series, step * np.arange(1, COUNT + 1), HARMONICS[how])
    rest, _ = linearised(term)
    if how == "orbits":
        family = Family(term, rest, series.basis, HARMONICS[how])
        beyond = follow(family, inside, step, FARTHEST[how][0] * amplitude)
    else:
        whole = replace(inside, values=inside.values @ series.basis.T)
        mode = series.manifold.masters.shapes[0].real
        shot = shoot(term, rest, mode, whole, FARTHEST[how][0] * amplitude)
        beyond = replace(shot, values=shot.values @ series.basis)
    order = series.manifold.monomials.order + MORE
    for times in FARTHEST[how]:
        some = inside.joined(beyond.within((times * amplitude) ** 2))
        manifold = fitted(series.manifold, series.basis, some, order)
        form = np.zeros((2, 2, 1 + len(manifold.monomials)), complex)
        form[:, :, 0] = symplectic_form(series.manifold, term.mass)[:, :, 0]
        yield replace(series, manifold=manifold, push=symplectic_push(manifold, form))


def orbits_of(
    model: ManifoldRom, series: ManifoldSeries, amplitude: np.ndarray, harmonics: int
) -> Orbits:
    """The motions of a model at these |z| (m,)."""
    angle = 2.0 * np.pi * np.arange(2 * harmonics + 1) / (2 * harmonics + 1)
    z = amplitude[:, None] * np.exp(1j * angle)
    forward = series.coordinates.forward
    y = (np.stack([z, z.conj()], axis=-1) @ forward.T).real
    rate = (model.drift(y) @ np.linalg.inv(forward).T)[..., 0] / z
    return Orbits(amplitude**2, rate.mean(axis=1), model.displacement(y) @ series.basis)
