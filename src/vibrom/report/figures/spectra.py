"""Spectra under random forcing

Spectral density of the probe's displacement under noise, averaged over realisations that are the
same for all models. One seed of each method is drawn: the median one by decay NMTE.
"""

from matplotlib.figure import Figure

from vibrom.report.branches import scenes
from vibrom.report.collection import FULL_ORDER, answered, at_probe
from vibrom.report.drawing import layout, panels, style
from vibrom.report.drawing.response import THIN, TRUTH
from vibrom.report.plots import Panel, Series
from vibrom.thesis.labels import label

FAMILY = "models"
PLACE = 569
EACH = "run"
DATA = ("random_forcing",)
ASKED = "random_forcing"  # where that is asked only
X, Y = "angular frequency [rad/s]", "spectral density [m² s/rad]"


def draw(collection, scores, scene=None) -> Figure:
    """A panel a scene."""
    shown = scenes(collection, "random_forcing")
    figure, axes = layout.grid(max(1, len(shown)), least=2.4, height=1.6)
    handles = {}
    for panel in axes:
        panel.set(xlabel=X, ylabel=Y)
    for name, panel in zip(shown, axes):
        panel.set(title=name, yscale="log")
        looks = style.looks(collection.methods)
        for model, _, answer in spectra(collection, scores, name):
            look = TRUTH if model == FULL_ORDER else looks[model] | THIN | {"marker": ""}
            handles[label(model)] = panel.plot(*line(answer), **look)[0]
    if not shown:
        layout.words(axes[0], "no random forcing in this run")
    if handles:
        layout.legend(figure, handles.values(), handles)
    return figure


def spectra(collection, scores, scene):
    """Model, seed and answer of each that has a spectrum, the full order first."""
    models = [FULL_ORDER, *collection.methods]
    for model in models:
        seed, answer = panels.drawn(collection, scores, scene, model, "random_forcing")
        if answered(answer):
            yield model, seed, answer


def line(answer):
    """Frequency and density, but for the mean."""
    frequency, density = answer["angular_frequency"].values, at_probe(answer, "spectral_density")
    return frequency[1:], density[1:]


def plot(collection, scores) -> list[Panel]:
    """Spectral density of the probe's displacement under noise, averaged over realisations; of each
    method the median seed.
    """
    made = []
    for name in scenes(collection, "random_forcing"):
        series = [
            Series(model, *line(answer), seed=None if model == FULL_ORDER else seed)
            for model, seed, answer in spectra(collection, scores, name)
        ]
        made.append(Panel(name, X, Y, series, log="y", switch="xy"))
    return made
