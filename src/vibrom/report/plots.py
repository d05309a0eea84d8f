"""Interactive plots of the page: series in panels, written as data and layout for Plotly.

A figure's file may have `plot(collection, scores) -> list[Panel]` beside its `draw`; the page then
shows these panels instead of the drawing, with the docstring of `plot` as caption, and the drawing
stays for print. Colours, dashes and markers are those of the figures.
"""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from vibrom.report.collection import FULL_ORDER
from vibrom.report.columns import number
from vibrom.report.drawing import style
from vibrom.thesis.labels import label

SYMBOLS = {
    "o": "circle",
    "s": "square",
    "^": "triangle-up",
    "D": "diamond",
    "v": "triangle-down",
    "P": "cross",
    "X": "x",
    "<": "triangle-left",
    ">": "triangle-right",
}
SHORT = 60  # values up to here are written as numbers, longer arrays as bytes
DIGITS = 5  # significant, of numbers
INK = "#1c2126"  # the colour of text on white, which the page replaces in the dark
FRONT = {  # a series: the Pareto front
    "name": "Pareto front",
    "look": {"linewidth": 1.2, "color": "#8a949e", "shape": "hv"},
}
NAMED = 6  # series that the words of a panel name


@dataclass(frozen=True)
class Series:
    """One line, or points, of one model."""

    method: str  # full_order or a method: it decides the look
    x: np.ndarray  # (k,) in the unit of the panel's axis
    y: np.ndarray  # (k,) NaN where there is no value
    seed: int | None = None
    mode: str = "lines"  # lines, markers or lines+markers
    notes: Sequence[str] = ()  # (k,) one more line of what hovering over a point tells
    name: str = ""  # besides method and seed
    faint: bool = False  # a seed that stands in the background
    low: np.ndarray | None = None  # (k,) ends of a vertical bar through each point
    high: np.ndarray | None = None
    look: Mapping[str, Any] = field(default_factory=dict)  # differs from the method's

    @property
    def title(self) -> str:
        """`SPLIT, seed 1, unstable`."""
        seed = "" if self.seed is None else f"seed {self.seed}"
        return ", ".join(part for part in (label(self.method), seed, self.name) if part)


@dataclass(frozen=True)
class Panel:
    """Two axes and what is drawn in them."""

    title: str
    x: str  # what the axis shows, with its unit
    y: str
    series: Sequence[Series]
    log: str = ""  # axes that are logarithmic at first: "", "x", "y" or "xy"
    switch: str = ""  # axes that the reader may switch between linear and logarithmic
    view: Mapping[str, tuple[float, float]] = field(default_factory=dict)  # axis -> range at first
    notes: Sequence[str] = ()  # what is not drawn, and why

    @property
    def short(self) -> str:
        """What is seen, in a breath."""
        count = sum(bool(np.isfinite(one.y).any()) for one in self.series)
        lines = f"{count} line{'s' if count != 1 else ''}"
        return f"{self.title}: {quantity(self.y)} against {quantity(self.x)}, {lines}."

    @property
    def seen(self) -> str:
        """The panel in words, from its numbers."""
        parts = [f"{self.title}: {quantity(self.y)} against {quantity(self.x)}."]
        drawn = [one for one in self.series if np.isfinite(one.y).any() and not one.faint]
        for one in drawn[:NAMED]:
            low, high = np.nanmin(one.y), np.nanmax(one.y)
            reach = number(float(high), 3)
            if high > low:
                at = number(float(one.x[np.nanargmax(one.y)]), 4)
                reach = f"{number(float(low), 3)} to {reach}, largest at {at}"
            parts.append(f"{one.title}: {reach}.")
        rest = len(drawn) - NAMED
        return " ".join([*parts, *([f"{rest} more lines."] if rest > 0 else []), *self.notes])

    def figure(self, looks: Mapping[str, dict]) -> dict[str, Any]:
        """As Plotly reads it."""
        made = {
            "data": [trace(one, self, looks[one.method]) for one in self.series if one.x.size],
            "layout": {"xaxis": self._axis("x"), "yaxis": self._axis("y")},
        }
        return made | {"switch": self.switch, "title": self.title}

    def _axis(self, name: str) -> dict[str, Any]:
        made: dict[str, Any] = {"title": {"text": getattr(self, name)}}
        if name in self.log:
            made["type"] = "log"
        if name in self.view:
            ends = np.asarray(self.view[name], float)
            made["range"] = rounded(np.log10(ends) if name in self.log else ends)
        return made


def quantity(axis: str) -> str:
    """Without the unit."""
    return axis.partition(" [")[0]


def unit(axis: str) -> str:
    """Without the quantity; empty where there is none."""
    words = axis.partition(" [")[2].removesuffix("]")
    return "" if words in ("–", "") else f" {words}"


def trace(one: Series, panel: Panel, base: Mapping[str, Any]) -> dict[str, Any]:
    """A series as Plotly reads it."""
    look = {**base, **one.look}
    colour = look["color"]
    hover = (
        f"<b>{one.title}</b><br>{quantity(panel.x)} %{{x:.5~g}}{unit(panel.x)}"
        f"<br>{quantity(panel.y)} %{{y:.4~g}}{unit(panel.y)}"
    )
    made: dict[str, Any] = {
        "type": "scatter",
        "mode": one.mode,
        "name": one.title,
        "meta": {"method": one.method},
        "hovertemplate": hover + ("<br>%{text}" if one.notes else "") + "<extra></extra>",
        **along(one.x),
        "y": values(one.y),
    }
    if "lines" in one.mode:
        made["line"] = {"color": colour, "width": look["linewidth"], "dash": dash(look)}
        made["line"] |= {"shape": look["shape"]} if "shape" in look else {}
    if "markers" in one.mode:
        symbol = SYMBOLS[look["marker"] or "o"]
        hollow = look.get("markerfacecolor") == "white"
        edge = {"width": 1.5, "color": colour}
        size = 1.6 * look.get("markersize", 4)
        shape = {"symbol": f"{symbol}-open" if hollow else symbol, "size": size}
        made["marker"] = {**shape, "color": colour, "line": edge}
    if one.notes:
        made["text"] = list(one.notes)
    if one.faint:
        made["opacity"] = 0.35
    if one.low is not None and one.high is not None:
        bars = {"type": "data", "symmetric": False, "thickness": 1.2, "width": 0, "color": colour}
        up = np.nan_to_num(one.high - one.y)
        made["error_y"] = {**bars, "array": rounded(up), "arrayminus": rounded(one.y - one.low)}
    return made


def along(x: np.ndarray) -> dict[str, Any]:
    """The abscissae; two numbers where they are equally spaced."""
    steps = np.diff(x)
    if x.size > SHORT and np.allclose(steps, steps[0], rtol=1e-6):
        return {"x0": float(x[0]), "dx": float(x[-1] - x[0]) / (x.size - 1)}
    return {"x": values(x)}


def values(array: np.ndarray) -> list | dict:
    """Numbers, or single-precision bytes where there are many."""
    array = np.asarray(array, float)
    if array.size <= SHORT:
        return rounded(array)
    return {"dtype": "f4", "bdata": base64.b64encode(array.astype("<f4").tobytes()).decode()}


def rounded(array: np.ndarray) -> list[float | None]:
    """To so many digits; None where there is no number."""
    return [float(f"{item:.{DIGITS}g}") if np.isfinite(item) else None for item in np.ravel(array)]


def dash(look: Mapping[str, Any]) -> str:
    """Lengths in pixels from those of matplotlib, which are in line widths."""
    pattern = look["linestyle"]
    if isinstance(pattern, str):
        return {"-": "solid", ":": "dot"}[pattern]
    return ",".join(f"{max(1.0, 1.3 * part):g}px" for part in pattern[1]) or "solid"


def looks(methods: Sequence[str]) -> dict[str, dict]:
    """Of the methods, and of the full order."""
    return {FULL_ORDER: style.FULL_ORDER | {"color": INK, "marker": "o"}} | style.looks(methods)
