"""Forced response curves at the probe, a panel a scene; failed points are counted."""

import numpy as np
from matplotlib.figure import Figure

from vibrom.report import curves
from vibrom.report.collection import FULL_ORDER, Collection, answered, at_probe, scalar
from vibrom.report.drawing import panels, style
from vibrom.report.plots import Panel, Series
from vibrom.report.scores import Scores
from vibrom.thesis.labels import label


def draw(
    collection: Collection, scores: Scores, quantity: str, axis: str, place: str
) -> tuple[Figure, list[int]]:
    """One variable of all models, and how many lines of notes each panel has at this place."""
    figure, axes = panels.grid(
        max(1, len(collection.scenes)), columns=3, size=(3.4, 3.5), legend=0.6
    )
    looks, handles, counts = style.looks(collection.methods), {}, []
    for panel, scene in zip(axes, collection.scenes):
        truth = collection.find(scene, FULL_ORDER, "frc")
        forcing = float(scalar(truth, "forcing"))
        panel.set(title=f"{scene}, forcing {forcing:g}" if np.isfinite(forcing) else scene)
        panel.set(xlabel="forcing frequency [rad/s]", ylabel=axis)
        notes = []
        if truth is not None:
            handles |= line(panel, truth, quantity, FULL_ORDER, style.FULL_ORDER)
        notes += note(truth, quantity, FULL_ORDER)
        for index, method in enumerate(collection.methods):
            _, curve = panels.drawn(collection, scores, scene, method, "frc")
            look = looks[method] | {"markevery": ((index + 1) % 3, 3), "linewidth": 0.9}
            if answered(curve):
                handles |= line(panel, curve, quantity, method, look)
            notes += note(curve, quantity, method)
        if notes:
            panels.words(panel, "\n".join(notes), place=place)
        counts.append(len(notes))
    figure.legend(list(handles.values()), list(handles), loc="outside lower center", ncols=4)
    return figure, counts


def line(panel, curve, quantity: str, model: str, look: dict) -> dict:
    """The curve, by its label."""
    omega, values = curve["angular_frequency"].values, at_probe(curve, quantity)
    return {label(model): panel.plot(omega, values, **look)[0]}


def note(curve, quantity: str, model: str) -> list[str]:
    """Why a curve is missing, or has gaps."""
    if curve is None:
        return [f"{label(model)}: not in this run"]
    if not answered(curve):
        return [f"{label(model)}: {panels.ending(curve, 'response curve')}"]
    whole = np.isfinite(at_probe(curve, quantity)).all()
    return [] if whole else [f"{label(model)}: {curves.finished(curve)}"]


def plot(collection: Collection, scores: Scores, quantity: str, axis: str) -> list[Panel]:
    """A panel a scene with all seeds; those that figures do not draw are faint."""
    made = []
    for scene in collection.scenes:
        truth, series, notes = collection.find(scene, FULL_ORDER, "frc"), [], []
        if answered(truth):
            omega = truth["angular_frequency"].values
            series.append(Series(FULL_ORDER, omega, at_probe(truth, quantity)))
            notes += note(truth, quantity, FULL_ORDER)
        for method in collection.methods:
            chosen, curve = panels.drawn(collection, scores, scene, method, "frc")
            for seed in collection.seeds(scene, method):
                if answered(found := collection.find(scene, method, "frc", seed)):
                    line = {"seed": seed, "faint": seed != chosen}
                    line |= {"notes": curves.outcomes(found, found.sizes["angular_frequency"])}
                    line |= {"look": {"linewidth": 1.2, "markersize": 3}, "mode": "lines+markers"}
                    x, y = found["angular_frequency"].values, at_probe(found, quantity)
                    series.append(Series(method, x, y, **line))
            notes += note(curve, quantity, method)
        forcing = float(scalar(truth, "forcing"))
        title = f"{scene}, forcing {forcing:g}" if np.isfinite(forcing) else scene
        view = bounds(truth, quantity)
        words = {"switch": "y", "notes": [f"{text}." for text in notes], "view": view}
        made.append(Panel(title, "forcing frequency [rad/s]", axis, series, **words))
    return made


def bounds(truth, quantity: str) -> dict[str, tuple[float, float]]:
    """The vertical range by the full order, so that a blow-up does not flatten it."""
    known = at_probe(truth, quantity) if answered(truth) else np.zeros(0)
    if not np.isfinite(known).any():
        return {}
    low, high = float(np.nanmin(known)), float(np.nanmax(known))
    return {"y": (low - 0.1 * (high - low), high + 0.25 * (high - low))}
