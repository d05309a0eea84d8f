"""Where the thesis and this project differ, and why; each point with a number of the run."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from vibrom.report.collection import FULL_ORDER, Collection, at_probe, probe_dof
from vibrom.report.columns import number
from vibrom.report.scores import Scores, offline
from vibrom.thesis import published as thesis
from vibrom.thesis.labels import CASES

REACH = CASES[::-1]  # the case that shows a point best, first


class Difference(NamedTuple):
    """A point."""

    title: str
    why: str
    here: str  # what this run shows


def points(collection: Collection, scores: Scores) -> list[Difference]:
    """Those that this run has a number for."""
    made = [(title, why, show(collection, scores)) for title, why, show in POINTS]
    return [Difference(*point) for point in made if point[2]]


def mesh(collection: Collection, scores: Scores) -> str:
    """First frequency of the mesh, and of quadratic elements on the same cells."""
    for scene in case(collection):
        structure = collection.find(scene, FULL_ORDER, "structure")
        if structure is not None and "frequency_quadratic" in structure:
            own, quadratic = (
                float(structure[name].values[0]) for name in ("frequency", "frequency_quadratic")
            )
            return (
                f"First frequency: {number(own)} rad/s on the mesh of the thesis, "
                f"{number(quadratic)} rad/s with quadratic elements."
            )
    return ""


def probe(collection: Collection, scores: Scores) -> str:
    """Probe and tip in the test state."""
    for scene in case(collection):
        structure, release = (
            collection.find(scene, FULL_ORDER, name) for name in ("structure", "release")
        )
        dofs = [] if structure is None else [probe_dof(structure, p) for p in ("probe", "tip")]
        if release is not None and len(dofs) == 2 and None not in dofs:
            free = release["displacement"].sel(role="test").values
            here, tip = (number(float(free[dof])) for dof in dofs)
            known = number(thesis.release(scene, "test"))
            return f"Test state of {scene}: thesis {known} m, probe here {here} m, tip {tip} m."
    return ""


def beside(method: str, experiment: str) -> Callable[[Collection, Scores], str]:
    """Our error and the thesis's."""

    def show(collection: Collection, scores: Scores) -> str:
        for scene in case(collection):
            ours = scores.spread(scene, method, experiment, "nmte_percent").median
            known = thesis.percent(experiment, scene, method)[0]
            if np.isfinite(ours) and np.isfinite(known):
                return (
                    f"Case {scene}: {number(ours, 3)} % here, {number(known, 3)} % in the thesis."
                )
        return ""

    return show


def order(collection: Collection, scores: Scores) -> str:
    """The same method with polynomials of order 3 and 11."""
    for scene in case(collection):
        low, high = (
            scores.spread(scene, method, "decay", "nmte_percent").median
            for method in ("ssmlearn", "ssmlearn_11")
        )
        if np.isfinite([low, high]).all():
            return f"Decay of {scene}: order 3 {number(low, 3)} %, order 11 {number(high, 3)} %."
    return ""


def upward(collection: Collection, scores: Scores) -> str:
    """The largest value and the half range of the full order's response."""
    for scene in case(collection):
        curve = collection.find(scene, FULL_ORDER, "frc")
        if curve is not None and "half_range" in curve:
            largest, half = (
                float(np.nanmax(at_probe(curve, name))) for name in ("amplitude", "half_range")
            )
            return (
                f"Largest response of {scene} from rest: maximum of y {number(largest)} m, half "
                f"its range {number(half)} m, at one of {curve.sizes['angular_frequency']} "
                "frequencies."
            )
    return ""


def time(collection: Collection, scores: Scores) -> str:
    """Seconds offline, full order and fit, beside the thesis's."""
    for scene in case(collection):
        for method in ("split_plus", "split", "ssmlearn"):
            ours = offline(scores.seconds(scene, method))
            names = ("generate_training_data_s", "obtain_mapping_s", "obtain_dynamics_s")
            known = np.nansum([thesis.run_time(name, scene, method) for name in names])
            if np.isfinite(ours) and known > 0:
                return (
                    f"Offline, {method.replace('_', ' ')} in case {scene}: {number(ours, 3)} s "
                    f"here, {number(float(known), 5)} s in the thesis."
                )
    return ""


def case(collection: Collection) -> list[str]:
    """The thesis's cases of this run, the one that bends most first."""
    return [scene for scene in REACH if scene in collection.scenes]


POINTS = (
    (
        "The mesh locks in shear",
        "Two rows of bilinear quadrilaterals are too stiff in bending, and the thesis studies that "
        "beam; its density of 440 kg/m³ is a tenth of titanium's. Both are kept, so that numbers "
        "can be compared.",
        mesh,
    ),
    (
        "Its tip is not the tip",
        "What the thesis labels as displacement of the tip is that of the node at x = 0.525 m on "
        "the bottom edge; it is called probe here.",
        probe,
    ),
    (
        "Learnt dynamics are of order one",
        "In seconds the coefficients of a reduced model span five decades, and Adam does not get "
        "there from one. Here time is scaled with the first frequency before training.",
        beside("sindy_autoencoder", "decay"),
    ),
    (
        "Training finds a better mapping",
        "Networks are trained in the leading directions of the training data, shuffled, with one "
        "learning-rate cycle, and every seed counts. The thesis trained ten times and kept one.",
        beside("split_plus", "decay"),
    ),
    (
        "It is the truncation that fails, not the fold",
        "The thesis concludes that a graph over the first mode fails because the beam folds. With "
        "the same data and encoder, only the order of the polynomials raised, it does not.",
        order,
    ),
    (
        "Forced runs of linear encoders",
        "Ours are integrated to a relative tolerance of 1e-8, those of the thesis to 1e-3; the "
        "difference is largest where motion is large and the model marginal.",
        beside("modal_projection", "forced"),
    ),
    (
        "A curve from rest is one branch",
        "Every frequency is started from rest, as in the thesis, so that coexisting motions and "
        "the peak between two frequencies are not seen.",
        upward,
    ),
    (
        "Run times",
        "Compiled element loops, few directions in place of 240 degrees of freedom, and another "
        "machine.",
        time,
    ),
)
