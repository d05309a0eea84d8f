"""A stop that one node runs into: unilateral contact by penalty, elastic or with losses.

    f = s k d (1 + c d')  while the depth d = s u - gap is positive and the bracket is too; s = +-1
    the side, u along one axis, d' = s v

Hunt and Crossley's damping c (J. Appl. Mech. 42 (1975) 440) is without force at the first touch and
never pulls; a mass that arrives at speed v leaves at e v with e = 1 - 2 c v/3 + O(c^2 v^2). c = 0
returns all energy. What the step h must resolve is the time in contact, about pi sqrt(m/k) with the
mass m that stops: the energy is kept to 0.5 % by 10 steps in it, to 0.05 % by 20 (trapezoidal
rule), and the error falls at least as h^2, though contacts begin and end within steps. A stiffer k
comes closer to a rigid stop (depth v sqrt(m/k)) and asks for smaller steps.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from vibrom.bodies.space import Space
from vibrom.config.kinds import Direction, NonNegative, Point, Positive
from vibrom.kernels.compiled import part
from vibrom.term import Force, Term, force_kernel, tangent_kernel

STAGE = "forces"
SIDES = {"positive": 1.0, "negative": -1.0}


@dataclass(frozen=True)
class Stop:
    at: Point  # m, a node
    direction: Direction
    gap: NonNegative  # m, between the node of the undeformed body and the stop
    stiffness: Positive  # N/m
    # of the node on which the stop lies, along the direction
    side: Literal["positive", "negative"] = "positive"
    damping: NonNegative = 0.0  # s/m

    def assemble(self, space: Space, base: Term) -> Term:
        dof = space.dof("effects.stop", self.at, self.direction)
        table = np.array([[SIDES[self.side], self.gap, self.stiffness, self.damping]])
        stop = Force(
            lambda width: (_force, _tangent),
            np.array([[dof]]),
            table,
            conservative=self.damping == 0.0,
            mean=lambda width: (_mean_force, _mean_tangent),
        )
        return Term(forces=(stop,))


@force_kernel
def _force(q, v, dofs, table, f):
    for e in range(dofs.shape[0]):
        dof, side, gap, stiffness, damping = (
            dofs[e, 0],
            table[e, 0],
            table[e, 1],
            table[e, 2],
            table[e, 3],
        )
        for w in range(q.shape[1]):
            depth, bracket = side * q[dof, w] - gap, 1.0 + damping * side * v[dof, w]
            if depth > 0.0 and bracket > 0.0:
                f[dof, w] += side * stiffness * depth * bracket


@tangent_kernel
def _tangent(q, v, dofs, table, slots, scale_q, scale_v, values):
    for e in range(dofs.shape[0]):
        dof, side, gap, stiffness, damping = (
            dofs[e, 0],
            table[e, 0],
            table[e, 1],
            table[e, 2],
            table[e, 3],
        )
        for w in range(q.shape[1]):
            depth, bracket = side * q[dof, w] - gap, 1.0 + damping * side * v[dof, w]
            if depth > 0.0 and bracket > 0.0:
                values[slots[e, 0], w] += stiffness * (
                    scale_q[w] * bracket + scale_v[w] * depth * damping
                )


@part
def mean_depth(before, after):
    """(p(after) - p(before))/(after - before) with p = d^2/2 where d > 0, and its derivative by
    `after`, at a fixed start.
    """
    if before > 0.0 and after > 0.0:
        return 0.5 * (before + after), 0.5
    if after > 0.0:  # it comes
        share = after / (after - before)
        return 0.5 * after * share, share * (1.0 - 0.5 * share)
    if before > 0.0:  # it leaves
        share = before / (before - after)
        return 0.5 * before * share, 0.5 * share * share
    return 0.0, 0.0


@force_kernel
def _mean_force(q, v, dofs, table, f):
    for e in range(dofs.shape[0]):
        dof, side, gap = dofs[e, 0], table[e, 0], table[e, 1]
        for w in range(q.shape[1]):
            middle, half = side * q[dof, w] - gap, side * q[v.shape[0] + dof, w]
            depth, _ = mean_depth(middle - half, middle + half)
            bracket = max(1.0 + table[e, 3] * side * v[dof, w], 0.0)
            f[dof, w] += side * table[e, 2] * depth * bracket


@tangent_kernel
def _mean_tangent(q, v, dofs, table, slots, scale_q, scale_v, values):
    for e in range(dofs.shape[0]):
        dof, side, gap, damping = dofs[e, 0], table[e, 0], table[e, 1], table[e, 3]
        for w in range(q.shape[1]):
            middle, half = side * q[dof, w] - gap, side * q[v.shape[0] + dof, w]
            depth, slope = mean_depth(middle - half, middle + half)
            bracket = 1.0 + damping * side * v[dof, w]
            if bracket > 0.0:
                values[slots[e, 0], w] += table[e, 2] * (
                    2.0 * scale_q[w] * slope * bracket + scale_v[w] * depth * damping
                )
