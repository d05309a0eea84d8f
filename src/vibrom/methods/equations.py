"""A model from the equations alone: the invariant manifold of some modes, parametrised directly.

    q = W(z),   v = V(z),   dz/dt = R(z) + S(z) p u

No motion is simulated and nothing is trained. The series are those of `solvers.manifold`; one mode
in normal form gets the action of its orbits for a coordinate, and with `beyond: pade` ratios of
polynomials, which hold beyond the series' radius of convergence. Among denominators of degree 0 to
3 in |z|^2 the one is taken whose model obeys the equations of motion farthest (`models.trust`).
That amplitude is the model's reach: a motion that leaves it ends as `left_range`. With `beyond:
orbits` or `shooting` periodic motions of the undamped body are followed farther, and polynomials
fitted to them (`latent.manifold_orbits`): they reach motions at which series of any order cease to
converge. Orbits have few harmonics, and cost least. By shooting, motions are exact but for their
time steps.

A load pushes z, by its part along the manifold, and adds a displacement beside it, both to first
order in the load and to any order in z.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import partial
from typing import ClassVar, Literal

import numpy as np
from threadpoolctl import threadpool_limits

from vibrom.config.kinds import Count, Fraction, Order, Tolerance
from vibrom.latent.manifold_orbits import followed
from vibrom.latent.manifold_rom import ManifoldRom
from vibrom.latent.manifold_series import ManifoldSeries
from vibrom.models.method import Method
from vibrom.models.training import MethodError, Training, Unsupported
from vibrom.models.trust import Residual, ellipse, equation_error, trust_curve, trusted
from vibrom.solvers.manifold.beside import beside
from vibrom.solvers.manifold.canonical import (
    action_coordinates,
    symplectic_form,
    symplectic_push,
)
from vibrom.solvers.manifold.covectors import carried, of_push
from vibrom.solvers.manifold.force import NoPolynomial
from vibrom.solvers.manifold.parametrisation import parametrise
from vibrom.term import Term

DENOMINATORS = (2, 1, 3, 0)  # degrees in |z|^2, the likeliest first
BESIDE = 11  # highest order of what the load adds beside the manifold, a small correction
FAR_BESIDE = 5  # likewise, where motions are farther than series of high order converge
FOLLOWED = ("orbits", "shooting")
LARGEST = 1500  # displacements of a body that is shot: the memory of a period goes by their square
TRUST_AT = (0.25, 0.5, 0.75, 1.0, 1.1, 1.25, 1.5)  # of the reach: where the error is recorded
FARTHEST = 8.0  # times the radius of convergence: where the search for the trusted amplitude begins


@dataclass(frozen=True)
class Equations(Method):
    """Needs the scene's equations of motion, and no motion."""

    of_equations: ClassVar[bool] = True

    modes: tuple[Count, ...] = (1,)  # counted from one
    order: Order = 15  # the higher, the closer where it is trusted; a lower one may reach farther
    style: Literal["normal_form", "graph"] = "normal_form"
    # the radius of convergence; orbits, shooting: of one mode in normal form, for the symplectic
    # force
    beyond: Literal["taylor", "pade", "orbits", "shooting"] = "pade"
    # by the symplectic form, exact for damping by the mass; or by the equations, for any damping
    force: Literal["symplectic", "invariance"] = "symplectic"
    detuning: Fraction = 0.1  # relative, up to which two frequencies of the manifold resonate
    tolerance: Tolerance = (
        0.01  # relative error of the equations of motion up to which it is trusted
    )

    def check(self) -> None:
        """See Method."""
        plain = self.style == "normal_form" and self.force == "symplectic"
        if self.beyond in FOLLOWED and not (plain and len(self.modes) == 1):
            raise MethodError(
                f"beyond is {self.beyond}, which follows motions of one mode in normal form with "
                "the symplectic force map; choose these, or beyond: pade"
            )

    def fit(self, training: Training) -> ManifoldRom:
        """The manifold of the term's equations; Unsupported where a force is no polynomial."""
        if training.term is None:
            raise MethodError("equations needs the scene's equations of motion, and got none")
        if self.beyond == "shooting" and training.term.size > LARGEST:
            raise MethodError(
                f"beyond is shooting, which is for bodies of at most {LARGEST} displacements, and "
                f"this one has {training.term.size}; choose orbits"
            )
        # Threads of BLAS would wait for those of the series, and for one another, in busy loops.
        with threadpool_limits(limits=1, user_api="blas"):
            try:
                series = self._series(training.term)
            except NoPolynomial as error:
                raise Unsupported(str(error)) from error
            return self._best(series, Residual(training.term))

    def _series(self, term: Term) -> ManifoldSeries:
        manifold = parametrise(term, self.modes, self.order, self.style, self.detuning)
        symplectic = self.force == "symplectic"
        known = min(self.order, FAR_BESIDE if self.beyond in FOLLOWED else BESIDE)
        if symplectic:
            manifold = manifold.with_forces(known)
        form = symplectic_form(manifold, term.mass)
        if self.style == "normal_form" and manifold.masters.mirror == (1, 0):
            manifold = action_coordinates(manifold, form)
            form = symplectic_form(manifold, term.mass)
        covectors = None if symplectic else carried(manifold)
        push = symplectic_push(manifold, form) if covectors is None else covectors.y
        if term.load is None or not term.load.any():
            return ManifoldSeries(manifold, push)
        lower = manifold.truncated(known)
        count = 1 + len(lower.monomials)
        if covectors is None:
            covectors = of_push(lower, push[:, :count])
        frequency = abs(manifold.masters.eigenvalues[0].imag)
        added = beside(lower, covectors.truncated(count), term.load, frequency)
        return ManifoldSeries(manifold, push, term.load, added)

    def _best(self, series: ManifoldSeries, residual: Residual) -> ManifoldRom:
        """The model that is trusted farthest, with its reach and what the trust rests on."""
        ratios = self.beyond != "taylor" and self.style == "normal_form" and series.of_circles
        best = self._farthest(map(series.model, DENOMINATORS if ratios else (0,)), residual)
        if self.beyond == "orbits" or self.beyond == "shooting":
            for each in followed(series, best, residual.term, self.beyond):
                farther = replace(each.model(0, aside=DENOMINATORS[0]), radius=best.radius)
                farther = self._farthest([farther], residual)
                if farther.reach[0] > best.reach[0]:
                    best = farther
                    break
        displacement, error = trust_curve(residual, best, TRUST_AT)
        return replace(best, trust_displacement=displacement, trust_error=error)

    def _farthest(self, models: Iterable[ManifoldRom], residual: Residual) -> ManifoldRom:
        """That of these models, alike in scale, which is trusted farthest; there is its reach."""
        best, amplitude = None, np.zeros(len(self.modes))
        for model in models:
            found = [
                trusted(
                    partial(_error, residual, model, i, self.tolerance),
                    self.tolerance,
                    FARTHEST,
                    least,
                )
                for i, least in enumerate(amplitude)
            ]
            if min(found) > amplitude.min():
                best, amplitude = model, np.array(found)
        if best is None:
            raise MethodError(
                f"tolerance is {self.tolerance:g}, and the manifold of order {self.order} keeps it "
                "at no amplitude; choose another order or a larger tolerance"
            )
        return replace(best, reach=best.reach * np.tile(amplitude, 2))


def _error(
    residual: Residual, model: ManifoldRom, oscillator: int, enough: float, amplitude: float
) -> float:
    return equation_error(residual, model, ellipse(model.reach, oscillator, amplitude), enough)
