"""Newmark's method as a scikit-fem user writes it today: forms, Newton's iteration, SciPy's sparse
LU.

The residual and the tangent of a St. Venant-Kirchhoff body are scikit-fem forms; mass and damping
are assembled once. Time step and the residual that counts as converged are those of
`vibrom.solvers.full.newmark`. As textbooks have it, a step starts from the last acceleration and
every iteration assembles and factorises its tangent; `tricks` adds what
`vibrom.solvers.full.newmark` does to need fewer of both: a higher-order guess and a factor that is
kept while the residual falls fast.
"""

import numpy as np
import skfem
from scipy.sparse.linalg import splu
from skfem.helpers import ddot, grad, identity, trace, transpose


class Beam:
    """M a + C v + f(q) = 0 on the free dofs of `basis`."""

    def __init__(
        self,
        basis: skfem.Basis,
        free: np.ndarray,
        mass,
        damping,
        young: float,
        nu: float,
        thickness: float,
    ):
        self.basis, self.free, self.mass, self.damping = basis, free, mass, damping
        shear = young / (2 * (1 + nu))
        plane = basis.mesh.dim() == 2  # stress
        lame = young * nu / ((1 - nu**2) if plane else (1 + nu) * (1 - 2 * nu))

        def strain_and_stress(w):
            gradient = w["u"].grad
            deformation = gradient + identity(gradient)
            strain = 0.5 * (
                gradient + transpose(gradient) + np.einsum("ki...,kj...->ij...", gradient, gradient)
            )
            return deformation, lame * trace(strain) * identity(gradient) + 2 * shear * strain

        def variation(deformation, v):
            product = np.einsum("ki...,kj...->ij...", deformation, grad(v))
            return 0.5 * (product + transpose(product))

        @skfem.LinearForm
        def internal(v, w):
            deformation, stress = strain_and_stress(w)
            return thickness * ddot(stress, variation(deformation, v))

        @skfem.BilinearForm
        def tangent(u, v, w):
            deformation, stress = strain_and_stress(w)
            change = variation(deformation, u)
            material = lame * trace(change) * identity(change) + 2 * shear * change
            geometric = np.einsum("ki...,kj...->ij...", grad(u), grad(v))
            return thickness * (ddot(material, variation(deformation, v)) + ddot(stress, geometric))

        self.internal_form, self.tangent_form = internal, tangent

    def _field(self, q: np.ndarray):
        full = np.zeros(self.basis.N)
        full[self.free] = q
        return self.basis.interpolate(full)

    def internal(self, q: np.ndarray) -> np.ndarray:
        return self.internal_form.assemble(self.basis, u=self._field(q))[self.free]

    def tangent(self, q: np.ndarray):
        return self.tangent_form.assemble(self.basis, u=self._field(q))[self.free][:, self.free]

    def run(
        self,
        q,
        h: float,
        steps: int,
        *,
        alpha: float,
        tolerance: float,
        patience: float,
        tricks: bool = False,
    ) -> np.ndarray:
        """Displacements (steps + 1, n) from rest in the state q, with zero acceleration."""
        gamma, beta = 0.5 + alpha, 0.25 * (1 + alpha) ** 2
        v, a, factor, history = np.zeros_like(q), np.zeros_like(q), None, [q]
        past = [a] * 4
        for _ in range(steps):
            guess = 3 * (a + past[2]) - 2 * (past[0] + past[1]) - past[3] if tricks else a
            past = [a, *past[:3]]
            q = q + h * v + h**2 * ((0.5 - beta) * a + beta * guess)
            v, a, previous = v + h * ((1 - gamma) * a + gamma * guess), guess, np.inf
            for iteration in range(25):
                body, spring = self.mass @ a + self.damping @ v, self.internal(q)
                residual = -body - spring
                norm = np.linalg.norm(residual)
                if iteration == 0:
                    scale = np.linalg.norm(body) + np.linalg.norm(spring)
                elif norm <= tolerance * scale:
                    break
                if (
                    not tricks
                    or factor is None
                    or norm * (norm / previous) ** patience > tolerance * scale
                ):
                    factor = splu(
                        (
                            self.mass + gamma * h * self.damping + beta * h**2 * self.tangent(q)
                        ).tocsc(),
                        permc_spec="MMD_AT_PLUS_A",
                        options={"SymmetricMode": True},
                    )
                change, previous = factor.solve(residual), norm
                a, v, q = a + change, v + gamma * h * change, q + beta * h**2 * change
            history.append(q)
        return np.array(history)
