"""The moving beam of the page: the test decay of the full order and of each method's model.

    q(t_j) = sum_k c_jk phi_k,   phi_k the leading singular vectors of all motions of the scene

q are displacements [m] of the nodes on the outline. So few phi_k that no node is further off than
`CLOSE` of the body's longest side; a frame then is a handful of whole numbers.
"""

from __future__ import annotations

import base64
from typing import Any

import numpy as np
import xarray as xr

from vibrom.models.rom import rom_from_dataset
from vibrom.report.collection import FULL_ORDER, Collection, answered, outcome
from vibrom.report.drawing import body, panels
from vibrom.report.plots import rounded
from vibrom.report.scores import Scores
from vibrom.thesis.labels import label

FRAMES = 25  # a period of the full order
LONGEST = 800  # frames
CLOSE = 5e-4
FAR = 3.0  # times the longest side: a model that is further out has run away
STEPS = 32767  # of a coefficient, up to its largest


def scenes(collection: Collection, scores: Scores) -> dict[str, dict[str, Any]]:
    """Scene -> outline, shapes and the coefficients of each model, of those with a test decay."""
    found = {scene: of_scene(collection, scores, scene) for scene in collection.scenes}
    return {scene: made for scene, made in found.items() if made}


def of_scene(collection: Collection, scores: Scores, scene: str) -> dict[str, Any] | None:
    """One scene; None where there is no motion to show."""
    structure, truth = collection.mesh(scene), collection.find(scene, FULL_ORDER, "test")
    if structure is None or truth is None or not outcome(truth).has_value:
        return None
    loops = body.outline(structure)
    nodes, side = np.concatenate(loops), body.longest_side(structure)
    time = truth["time"].values
    stride = frame_stride(time, float(truth["period"]))
    pick = Picker(structure, nodes)
    motions = {FULL_ORDER: pick(truth["displacement"][::stride].values)}
    titles = {FULL_ORDER: label(FULL_ORDER)}
    for method in collection.methods:
        seed, decay = panels.drawn(collection, scores, scene, method, "decay")
        free = predicted(collection.find(scene, method, "rom", seed), decay, stride)
        if free is not None:
            error = scores.value(scene, method, seed, "decay", "nmte_percent")
            titles[method] = panels.title(method, seed, error)
            motions[method] = within(pick(free), FAR * side)
    shapes = basis(np.concatenate(list(motions.values())), CLOSE * side)
    made = {method: coefficients(motion, shapes) for method, motion in motions.items()}
    largest = np.max([np.abs(values).max(axis=0) for values in made.values()], axis=0)
    scale = np.where(largest > 0, largest, 1.0) / STEPS
    return {
        "start": 0.0,
        "step": float(time[stride] - time[0]),
        "frames": len(motions[FULL_ORDER]),
        "loops": [len(loop) for loop in loops],
        "rest": rounded(body.rest(structure)[nodes] @ body.view(structure).T),
        "shapes": packed(shapes * scale[:, None], "<f4"),
        "rank": len(shapes),
        "tip": int(np.argmax(np.ptp(motions[FULL_ORDER], axis=0).reshape(-1, 2).max(axis=1))),
        "models": [
            {"method": method, "title": titles[method], "motion": packed(values / scale, "<i2")}
            for method, values in made.items()
        ],
    }


class Picker:
    """(frame, dof) displacements to (frame, 2 * nodes) of these nodes on the page, across and up by
    turns.
    """

    def __init__(self, structure: xr.Dataset, nodes: np.ndarray):
        size = structure.sizes["dof"]
        place = body.displacement(structure, np.arange(1.0, size + 1))[nodes]
        self.dofs = place.astype(int) - 1  # (nodes, axes), -1: clamped
        self.view = body.view(structure)

    def __call__(self, free: np.ndarray) -> np.ndarray:
        """Those displacements [m]."""
        moved = np.where(self.dofs >= 0, free[:, self.dofs], 0.0)
        return (moved @ self.view.T).reshape(len(free), -1)


def frame_stride(time: np.ndarray, period: float) -> int:
    """Every how many samples there is a frame."""
    a_period = period / (time[1] - time[0])
    return max(1, int(a_period // FRAMES), -(-len(time) // LONGEST))


def predicted(rom: xr.Dataset | None, decay: xr.Dataset | None, stride: int) -> np.ndarray | None:
    """Displacement (frame, dof) of a model's decay; None where it has none."""
    if rom is None or not answered(rom) or decay is None or "reduced" not in decay:
        return None
    reduced = decay["reduced"].transpose("time", "coordinate").values[::stride]
    good = np.isfinite(reduced).all(axis=1)
    count = len(good) if good.all() else int(np.argmin(good))
    return rom_from_dataset(rom).displacement(reduced[:count]) if count else None


def within(motion: np.ndarray, reach: float) -> np.ndarray:
    """Up to the first frame that is further out than this."""
    far = np.abs(motion).max(axis=1) > reach
    return motion[: int(np.argmax(far))] if far.any() else motion


def basis(motion: np.ndarray, close: float) -> np.ndarray:
    """(rank, coordinate) shapes that have every frame up to `close`."""
    # Of their products, which are as many as coordinates: frames are many more.
    shapes = np.linalg.eigh(motion.T @ motion)[1].T[::-1]
    for rank in range(1, len(shapes) + 1):
        kept = shapes[:rank]
        if np.abs(motion - motion @ kept.T @ kept).max() <= close:
            return kept
    return shapes


def coefficients(motion: np.ndarray, shapes: np.ndarray) -> np.ndarray:
    """(frame, rank)."""
    return motion @ shapes.T


def packed(values: np.ndarray, kind: str) -> str:
    """The bytes of an array, rounded where they are of whole numbers."""
    whole = np.rint(values) if "i" in kind else values
    return base64.b64encode(np.ascontiguousarray(whole, kind).tobytes()).decode()
