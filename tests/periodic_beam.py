"""A short clamped beam that bends far, for the tests of periodic motions."""

import numpy as np
from scenes import THESIS, body

from vibrom import effects
from vibrom.bodies import space
from vibrom.solvers.full.newmark import Newmark
from vibrom.solvers.periodic import symmetry
from vibrom.solvers.periodic.newmark_map import NewmarkMap

STOP = {"at": [1.0, 0.1], "direction": "y", "gap": 2e-3, "stiffness": 1e5, "damping": 0.1}
SHORT = body(cells=[4, 1], height=0.1)
TRACTION = {"edge": "right", "pressure": 1e6, "shear": 1e6}


def beam(extra=None, steps=200, body=SHORT, mirrored=True, **newmark):
    """It, and more effects."""
    made = space.build(body)
    term = effects.assemble(made, {**THESIS, **(extra or {})})
    found = symmetry.candidates(made.dof_location, made.dof_axis, made.size)
    found = [s for s in found if symmetry.holds(s, term)] if mirrored else []
    settings = Newmark(alpha=0.005, **newmark)
    probes, rest = np.array([made.size - 1]), np.zeros(made.size)
    return NewmarkMap(term, settings, steps, 2000.0, probes, rest, found[0] if found else None)


def periodic(flow, frequency, amplitude, near=None):
    """The motion at this forcing, by Newton's iteration from rest, or from a point near it."""
    x = np.zeros(flow.size) if near is None else near
    for _ in range(8):
        found = flow(x, frequency, amplitude)
        x = x + np.linalg.solve(np.eye(flow.size) - found.by_start, found.end - x)
    assert np.linalg.norm(flow(x, frequency, amplitude).end - x) < 1e-7 * np.linalg.norm(x)
    return x


CASES = {
    "mirrored": ({}, {}),
    "whole period": ({}, {"mirrored": False}),
    "a stop with losses": ({"stop": STOP}, {}),
    "stiffness damping": (
        {"rayleigh_damping": {"damping_ratio": 0.01, "stiffness_factor": 1e-6}},
        {},
    ),
    "follower load": ({"follower_load": TRACTION}, {}),
    "sparse": ({}, {"widest_band": 3}),
}
