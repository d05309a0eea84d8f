"""A model from the equations alone: the invariant manifold of some modes, parametrised directly.

    q = W(z),   v = V(z),   dz/dt = R(z) + S(z) p u

No motion is simulated and nothing is trained. The series are those of `solvers.manifold`; one mode
in normal form gets the action of its orbits for a coordinate, and with `beyond: pade` ratios of
polynomials, which hold beyond the series' radius of convergence. Among denominators of degree 0 to
3 in |z|^2 the one is taken whose model obeys the equations of motion farthest (`models.trust`).
That amplitude is the model's reach: a motion that leaves it ends as `left_range`.

A load pushes z, by its part along the manifold, and adds a displacement beside it, both to first
order in the load and to any order in z.
"""

from dataclasses import dataclass, replace
from functools import partial
from typing import ClassVar, Literal

import numpy as np

from vibrom.config.kinds import Count, Fraction, Order, Tolerance
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
TRUST_AT = (0.25, 0.5, 0.75, 1.0, 1.1, 1.25, 1.5)  # of the reach: where the error is recorded
FARTHEST = 8.0  # times the radius of convergence: where the search for the trusted amplitude begins


@dataclass(frozen=True)
class Equations(Method):
    """Needs the scene's equations of motion, and no motion."""

    of_equations: ClassVar[bool] = True

    modes: tuple[Count, ...] = (1,)  # counted from one
    order: Order = 15  # the higher, the closer where it is trusted; a lower one may reach farther
    style: Literal["normal_form", "graph"] = "normal_form"
    beyond: Literal["taylor", "pade"] = "pade"  # the radius of convergence
    # by the symplectic form, exact for damping by the mass; or by the equations, for any damping
    force: Literal["symplectic", "invariance"] = "symplectic"
    detuning: Fraction = 0.1  # relative, up to which two frequencies of the manifold resonate
    tolerance: Tolerance = (
        0.01  # relative error of the equations of motion up to which it is trusted
    )

    def fit(self, training: Training) -> ManifoldRom:
        """The manifold of the term's equations; Unsupported where a force is no polynomial."""
        if training.term is None:
            raise MethodError("equations needs the scene's equations of motion, and got none")
        with training.monitor.phase("mapping"):
            try:
                series = self._series(training.term)
            except NoPolynomial as error:
                raise Unsupported(str(error)) from error
        with training.monitor.phase("dynamics"):
            return self._best(series, Residual(training.term))

    def _series(self, term: Term) -> ManifoldSeries:
        manifold = parametrise(term, self.modes, self.order, self.style, self.detuning)
        form = symplectic_form(manifold, term.mass)
        if self.style == "normal_form" and manifold.masters.mirror == (1, 0):
            manifold = action_coordinates(manifold, form)
            form = symplectic_form(manifold, term.mass)
        if self.force == "symplectic":
            covectors = of_push(manifold, symplectic_push(manifold, form))
        else:
            covectors = carried(manifold)
        if term.load is None or not term.load.any():
            return ManifoldSeries(manifold, covectors.y)
        lower = manifold.truncated(min(self.order, BESIDE))
        frequency = abs(manifold.masters.eigenvalues[0].imag)
        added = beside(lower, covectors.truncated(len(lower.monomials)), term.load, frequency)
        return ManifoldSeries(manifold, covectors.y, term.load, added)

    def _best(self, series: ManifoldSeries, residual: Residual) -> ManifoldRom:
        """The model that is trusted farthest, with its reach and what the trust rests on."""
        ratios = self.beyond == "pade" and self.style == "normal_form" and series.of_circles
        best, amplitude = None, np.zeros(len(self.modes))
        for degree in DENOMINATORS if ratios else (0,):
            model = series.model(degree)
            found = [
                trusted(partial(_error, residual, model, i), self.tolerance, FARTHEST, least)
                for i, least in enumerate(amplitude)
            ]
            if min(found) > amplitude.min():
                best, amplitude = model, np.array(found)
        if best is None:
            raise MethodError(
                f"tolerance is {self.tolerance:g}, and the manifold of order {self.order} keeps it "
                "at no amplitude; choose another order or a larger tolerance"
            )
        best = replace(best, reach=best.reach * np.tile(amplitude, 2))
        displacement, error = trust_curve(residual, best, TRUST_AT)
        return replace(best, trust_displacement=displacement, trust_error=error)


def _error(residual: Residual, model: ManifoldRom, oscillator: int, amplitude: float) -> float:
    return equation_error(residual, model, ellipse(model.reach, oscillator, amplitude))
