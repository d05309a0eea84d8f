"""Bodies and effects that several tests share: the thesis's cantilever, and small ones."""

CANTILEVER = {
    "length": 1.0,
    "height": 0.02,
    "width": 0.05,
    "cells": [40, 2],
    "element": "bilinear",
    "clamped": ["left"],
    "probes": {
        "probe": {"at": [0.525, 0.0], "direction": "y"},
        "tip": {"at": [1.0, 0.01], "direction": "y"},
    },
}
ELASTICITY = {"young_modulus": 104.0e9, "poisson_ratio": 0.3, "plane": "stress"}
SLENDER = {**ELASTICITY, "poisson_ratio": 0.0}  # what beam theory assumes
LINEAR = {"inertia": {"density": 440.0}, "elasticity": ELASTICITY}
BEAM = {"inertia": {"density": 440.0}, "elasticity": SLENDER}
BENDING, LINE = (
    104.0e9 * 0.05 * 0.02**3 / 12,
    440.0 * 0.05 * 0.02,
)  # EI [N m2] and mass a metre [kg/m] of CANTILEVER
UNDAMPED = {**LINEAR, "geometric_nonlinearity": {}}
THESIS = {**UNDAMPED, "rayleigh_damping": {"damping_ratio": 0.01}, "modal_load": {"mode": 1}}


def body(**changes):
    return {**CANTILEVER, "probes": {}, **changes}


def quadratic_body(**changes):
    return body(element="quadratic", **changes)
