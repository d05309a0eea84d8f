"""What a reproduction of the thesis promises, and the model from the equations of motion beside it,
as data: numbers of models, and the bounds that they have to meet.

First frequency, release states and tip displacements under forcing are those of a reference
reproduction of the thesis's beam; errors and eigenvalues are those that the thesis prints.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

from vibrom.config.places import FULL_ORDER
from vibrom.thesis import published
from vibrom.thesis.labels import CASES

BODY = {"length": 1.0, "height": 0.02, "width": 0.05, "cells": [40, 2], "element": "bilinear"}
EFFECTS = {  # what differs from the effects' own defaults
    "inertia": {"density": 440.0},
    "elasticity": {"young_modulus": 104.0e9, "poisson_ratio": 0.3, "plane": "stress"},
    "geometric_nonlinearity": {},
    "rayleigh_damping": {"damping_ratio": 0.01},
    "modal_load": {"mode": 1},
}
FORCING = dict(zip(CASES, (1.0, 600.0, 6000.0), strict=True))  # of forced runs, response curves
REFERENCE, PROMISE = "reference reproduction", "promise"


class Bound(NamedTuple):
    """An interval, and the words for it."""

    low: float
    high: float
    text: str

    def met(self, value: float) -> bool:
        """Is the value in the interval? A missing number (NaN) is in none."""
        return self.low <= value <= self.high


def within(reference: float, percent: float) -> Bound:
    """Of the reference."""
    width = percent / 100 * abs(reference)
    return Bound(reference - width, reference + width, f"{reference:.6g} within {percent:g} %")


def at_most(high: float) -> Bound:
    """The bound included."""
    return Bound(-math.inf, high, f"at most {high:.6g}")


def below(high: float) -> Bound:
    """The bound excluded."""
    return Bound(-math.inf, math.nextafter(high, -math.inf), f"below {high:g}")


ZERO = Bound(0.0, 0.0, "0")


class Promise(NamedTuple):
    """One number of one model."""

    method: str
    quantity: str
    at: tuple[str, ...]  # where our number stands: (experiment, score), (guards, guard, column), ..
    unit: str
    bound: Bound
    source: str
    needs: set[str]  # which of the thesis's releases (train, test) and forcings it depends on


# Largest tip displacement of the last forced period [m], and how close to it [%].
TIP = {"small": (0.00095, 0.5), "large": (0.4678, 0.2), "folding": (0.8285, 0.2)}
# Of the response curve with all branches, in terms of the damped first frequency, from long time
# marching with the motion carried on: the main folds lie between a frequency at which it stays on
# its branch and one at which it has left it. Case -> quantity -> its bound.
BRANCHES = {
    "large": {
        "main folds": ZERO,
        "peak": within(0.1944, 0.1),  # m
        "peak frequency": within(1.0053, 0.02),
    },
    "folding": {
        "main folds": Bound(2.0, 2.0, "2"),
        "upper fold": Bound(1.04, 1.0423, "1.04 to 1.0423"),
        "lower fold": Bound(1.03, 1.0312, "1.03 to 1.0312"),
        "stable peak": Bound(0.448, math.inf, "at least 0.448"),  # m
        "motions": Bound(100.0, math.inf, "at least 100"),
    },
}
OMEGA_1 = Bound(398.0514, 398.0534, "398.0524 within 0.001")  # rad/s

# Quantity -> where it stands, its unit, what it depends on, and the table of the thesis.
MEASURES = {
    "reconstruction NMTE": (("reconstruction", "nmte_percent"), "%", {"train", "test"}, "3.3"),
    "decay NMTE": (("decay", "nmte_percent"), "%", {"train", "test"}, "3.4"),
    "forced NMTE": (("forced", "nmte_percent"), "%", {"train", "forced"}, "3.5"),
    "eigenvalue, real part": (("eigenvalues", "real_per_s"), "1/s", {"train"}, "3.2"),
    "eigenvalue, imaginary part": (
        ("eigenvalues", "imaginary_rad_per_s"),
        "rad/s",
        {"train"},
        "3.2",
    ),
}
FITTED_ONCE = ("modal_projection", "ssmlearn")
TRAINED = ("decoupled_autoencoder", "sindy_autoencoder", "split", "split_plus")
# What is as close to the printed number as this [%], and what must be no larger than it.
AS_PRINTED = {
    "reconstruction NMTE": 0.5,
    "decay NMTE": 4.0,
    "eigenvalue, real part": 0.5,
    "eigenvalue, imaginary part": 0.5,
}
NO_LARGER = {
    **dict.fromkeys(TRAINED, ("reconstruction NMTE", "decay NMTE")),
    "split_plus": ("reconstruction NMTE", "decay NMTE", "forced NMTE"),
}
# Method -> guard, by its name in the configuration, with which it follows the folding case.
GUARDED = {"split_plus": "dissipative_9", "decoupled_autoencoder": "dissipative_9"}
FOLLOWED = (
    ("points without value", "points_without_value", "1", ZERO),
    ("median amplitude error", "median_amplitude_error_percent", "%", at_most(2.0)),
    ("peak amplitude", "peak_error_percent", "%", Bound(-3.0, 3.0, "0 within 3")),
    ("place of the peak", "peak_steps", "1", at_most(1)),
)
# Models from the equations of motion: method -> quantity -> where it stands, its unit, what it
# depends on, and the largest value in the cases small, large and folding.
CURVE = {
    "frc, median amplitude error": ("frc", "amplitude_error_median_percent"),
    "frc, largest amplitude error": ("frc", "amplitude_error_largest_percent"),
}
EQUATIONS = {
    "equations": {
        "decay NMTE": (("decay", "nmte_percent"), "%", {"test"}, (0.035, 0.04, 0.1)),
        "decay NMTE, converged": (
            ("decay", "converged_nmte_percent"),
            "%",
            {"test"},
            (0.001, 0.007, 0.1),
        ),
        "offline time": (("offline",), "s", set(), (0.3, 0.3, 0.3)),
    },
    "equations_orbits": {
        quantity: (at, "%", {"frc"}, bounds)
        for (quantity, at), bounds in zip(CURVE.items(), ((0.02, 0.02, 1.0), (0.2, 0.2, 2.0)))
    },
}
# Models that know of the two motions of `folding`: largest error of the frequency of a fold [%].
FOLDED = {
    "equations_orbits": 0.3,
    "equations_corrected": 1.0,
    "decoupled_autoencoder": 1.0,
    "sindy_autoencoder": 1.0,
}


def of_full_order(case: str) -> Iterator[Promise]:
    """First frequency, release states, largest tip displacement, landmarks of its branches."""
    yield Promise(
        FULL_ORDER, "omega_1", ("structure", "omega_1"), "rad/s", OMEGA_1, REFERENCE, set()
    )
    for role in ("train", "test"):
        for probe in ("probe", "tip", "tip_x"):
            bound = within(published.state(case, role)[f"{probe}_m"], 0.1)
            quantity, at = f"{role} release, {probe}", ("release", role, probe)
            yield Promise(FULL_ORDER, quantity, at, "m", bound, REFERENCE, {role})
    bound, at = within(*TIP[case]), ("forced", "tip")
    yield Promise(FULL_ORDER, "forced, largest tip", at, "m", bound, REFERENCE, {"forced"})
    for words, bound in BRANCHES.get(case, {}).items():
        quantity, at = f"branches, {words}", ("branches", words)
        unit = "m" if words.endswith("peak") else "1"
        yield Promise(FULL_ORDER, quantity, at, unit, bound, REFERENCE, {"branches"})


def of_method(case: str, method: str, frequency: float) -> Iterator[Promise]:
    """Errors and eigenvalues; `frequency` [rad/s] is the full order's, damped."""
    for quantity, percent in AS_PRINTED.items() if method in FITTED_ONCE else ():
        yield _promise(method, quantity, within(_printed(quantity, case, method), percent))
    for quantity in NO_LARGER.get(method, ()):
        yield _promise(method, quantity, at_most(_printed(quantity, case, method)))
    if method == "sindy_autoencoder":  # the thesis's fails
        yield _promise(method, "decay NMTE", below(10), PROMISE)
        yield _promise(method, "eigenvalue, imaginary part", within(frequency, 5.0), "full order")
        yield _promise(method, "eigenvalue, real part", below(0), PROMISE)
    for quantity, (at, unit, needs, bounds) in EQUATIONS.get(method, {}).items():
        bound = at_most(bounds[list(FORCING).index(case)])
        yield Promise(method, quantity, at, unit, bound, PROMISE, needs)
    if method in FOLDED and case == "folding":
        folds = ("branches", "fold_frequency_error_percent")
        bound = at_most(FOLDED[method])
        yield Promise(method, "fold frequency", folds, "%", bound, PROMISE, {"branches"})
        wrong = ("branches", "wrong_stable_motions")
        quantity = "frequencies with a wrong number of stable motions"
        yield Promise(method, quantity, wrong, "1", ZERO, PROMISE, {"branches"})
    if method in GUARDED and case == "folding":
        guard = GUARDED[method]
        for words, column, unit, bound in FOLLOWED:
            quantity, at = f"frc with guard {guard}, {words}", ("guards", guard, column)
            yield Promise(method, quantity, at, unit, bound, PROMISE, {"train", "frc"})


def _promise(method: str, quantity: str, bound: Bound, source: str = "") -> Promise:
    at, unit, needs, table = MEASURES[quantity]
    return Promise(method, quantity, at, unit, bound, source or f"thesis, Table {table}", needs)


def _printed(quantity: str, case: str, method: str) -> float:
    """The thesis's number."""
    experiment, score = MEASURES[quantity][0]
    if experiment == "eigenvalues":
        return published.eigenvalue(case, method)[score != "real_per_s"]
    return published.percent(experiment, case, method)[0]
