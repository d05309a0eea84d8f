"""How figures are laid out: as wide as a column of a journal and in true size, panels in rows,
notes above the panels and legends below. Nothing is written on the data.
"""

import math
from collections.abc import Iterable
from itertools import pairwise

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.axis import Axis, Tick
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.textpath import text_to_path
from matplotlib.ticker import FixedLocator, LogLocator, MaxNLocator
from matplotlib.transforms import ScaledTranslation

COLUMN = 3.46  # [inches] of a figure: 88 mm
SIZE = 7  # [points] of letters
SMALL = 6.2  # of the smallest
LINE = 1.3  # height of a line, over the size of its letters
NUMBERS = 0.33  # [inches] left of a panel, for those of its axis
NARROW = 1.5  # of a panel with few numbers along its axis
POINTS = 72  # an inch
NOTE, NAME = "note", "name"  # what the text of a panel is: `finish` and `place` find it by this
# Where the name of a point may stand [points]; the first place that is free.
PLACES = ((4, 3), (-4, 3), (4, -9), (-4, -9), (0, 6), (0, -12), (9, -3), (-9, -3))


def grid(
    count: int, *, least: float = 1.6, height: float = 1.0, **subplots
) -> tuple[Figure, list[Axes]]:
    """A figure and `count` axes of this height; as many in a row as may have a width of `least`,
    labels included [inches].
    """
    columns = max(1, min(count, int(COLUMN / least)))
    rows = max(1, math.ceil(count / columns))
    figure = Figure(figsize=(COLUMN, rows * height))
    axes = figure.subplots(rows, columns, squeeze=False, **subplots).ravel()
    for spare in axes[count:]:
        spare.remove()
    return figure, list(axes[:count])


def words(axes: Axes, text: str) -> None:
    """A note on what a panel does not show: above it, or in the middle of one that is empty."""
    axes.text(0.5, 0.5, text, gid=NOTE, fontsize=SMALL, style="italic")


def name(axes: Axes, text: str, point: tuple[float, float], **look) -> None:
    """The name of a point of the data, beside it; none where there is no room."""
    given = {"textcoords": "offset points", "fontsize": SMALL, "gid": NAME}
    axes.annotate(text, point, xytext=PLACES[0], **given | look)


def heading(figure: Figure, text: str) -> None:
    """Above all panels."""
    words = fold(text, COLUMN - 0.2, SIZE, style="italic")
    figure.suptitle(words, fontsize=SIZE, x=0.01, ha="left", style="italic")


def legend(figure: Figure, handles: Iterable[Artist], labels: Iterable[str]) -> None:
    """Every line once, below, in as many columns as there is room for."""
    handles, labels = list(handles), list(labels)
    if not handles:
        return
    mark = 2.6 * SMALL + 1.8 * SMALL  # line, and the gaps beside it
    names = [fold(text, COLUMN - 2 * mark / POINTS, SMALL) for text in labels]
    longest = max(width(line, SMALL) for text in names for line in text.split("\n"))
    columns = int(COLUMN * POINTS / (mark + longest))
    columns = max(1, min(columns, len(names)))
    look = {"handlelength": 2.6, "handletextpad": 0.5, "columnspacing": 1.0}
    place = {"loc": "outside lower center", "ncols": columns}
    figure.legend(handles, names, fontsize=SMALL, **look, **place)


def legend_below(panel: Axes) -> None:
    """The lines of one panel, a row each; `finish` puts it below the panel."""
    handles, labels = panel.get_legend_handles_labels()
    names = [fold(text, COLUMN - 1.1, SMALL) for text in labels]
    panel.legend(handles, names, loc="upper left", handlelength=2.6, borderaxespad=0.0)


def of_panels(figure: Figure) -> tuple[list[Artist], list[str]]:
    """The lines of all panels that have a label, each label once."""
    found: dict[str, Artist] = {}
    for panel in figure.axes:
        for handle, text in zip(*panel.get_legend_handles_labels()):
            found.setdefault(text, handle)
    return list(found.values()), list(found)


def width(text: str, size: float, **font: str) -> float:
    """[points] of words on one line."""
    look = FontProperties(size=size, **font)
    return text_to_path.get_text_width_height_descent(text, look, ismath=False)[0]


def fold(text: str, inches: float, size: float, **font: str) -> str:
    """On as many lines as it needs to be no wider than this; formulas are left alone."""
    lines = []
    for line in text.split("\n"):
        lines.append("")
        for word in line.split(" "):
            longer = f"{lines[-1]} {word}".strip()
            if lines[-1] and "$" not in text and width(longer, size, **font) > inches * POINTS:
                lines.append(word)
            else:
                lines[-1] = longer
    return "\n".join(lines)


def finish(figure: Figure) -> None:
    """Labels that neighbours share stand once, long words are wrapped, notes move above their
    panels, and the figure gets the height that all of that needs.
    """
    panels = [panel for panel in figure.axes if panel.get_subplotspec() is not None]
    bars = len(figure.axes) - len(panels)
    share(panels)
    rows: dict[float, float] = {}
    for panel in panels:
        row = round(panel.get_position(original=True).y0, 6)
        rows[row] = max(rows.get(row, 0.0), wrapped(figure, panel))
    words = [text.get_text() for text in (figure._suptitle,) if text]
    lines = sum(text.count("\n") + 1 for text in words)
    for one in figure.legends:
        texts = [text.get_text().count("\n") + 1 for text in one.get_texts()]
        lines += math.ceil(sum(texts) / one._ncols) + 1
    points = sum(rows.values()) + LINE * SIZE * lines + 30 * bars
    figure.set_figheight(figure.get_figheight() + points / POINTS)


def share(panels: list[Axes]) -> None:
    """A label stands once below panels that are one below another, and once beside those of a
    row.
    """
    boxes = np.round(
        [panel.get_position(original=True).extents for panel in panels], 6
    )  # left, bottom, ...
    for panel, box in zip(panels, boxes):
        below = (boxes[:, 0] == box[0]) & (boxes[:, 2] == box[2]) & (boxes[:, 1] < box[1])
        left = (boxes[:, 1] == box[1]) & (boxes[:, 3] == box[3]) & (boxes[:, 0] < box[0])
        if below.any() and panel.get_legend() is None:
            near = panels[int(np.where(below, boxes[:, 1], -1.0).argmax())]
            panel.xaxis.label.set_visible(near.get_xlabel() != panel.get_xlabel())
        if left.any():
            near = panels[int(np.where(left, boxes[:, 0], -1.0).argmax())]
            panel.yaxis.label.set_visible(near.get_ylabel() != panel.get_ylabel())


def cell(figure: Figure, panel: Axes) -> tuple[float, float]:
    """Width and height [inches] of what a panel has of the figure, labels included: the share of
    all panels and gaps before anything is laid out.
    """
    box, parts = panel.get_position(original=True), figure.subplotpars
    sides = []
    for size, whole, gap, length in (
        (box.width, parts.right - parts.left, parts.wspace, COLUMN),
        (box.height, parts.top - parts.bottom, parts.hspace, figure.get_figheight()),
    ):
        sides.append(length * (1 + gap) / (whole / size + gap))
    return sides[0], sides[1]


def wrapped(figure: Figure, panel: Axes) -> float:
    """Wraps the words around a panel; the height [points] that they need."""
    across, along = cell(figure, panel)
    panel.set_ylabel(fold(panel.get_ylabel(), along + 0.2, SIZE))
    lines = panel.get_ylabel().count("\n") + 1
    room = across - NUMBERS - LINE * SIZE * lines / POINTS
    panel.set_xlabel(fold(panel.get_xlabel(), room, SIZE))
    if room < NARROW and isinstance(panel.xaxis.get_major_locator(), MaxNLocator):
        panel.locator_params(axis="x", nbins=3)  # or their numbers meet
    title = fold(panel.get_title(loc="left"), 0.9 * room, SIZE, weight="bold")
    above = noted(panel, room)
    panel.set_title(title, pad=3 + above)
    above += LINE * SIZE * (title.count("\n") + 1) if title else 0
    below = LINE * SIZE * (panel.get_xlabel().count("\n") + 1)
    below = below if panel.get_xlabel() and panel.xaxis.label.get_visible() else 0
    if panel.xaxis.get_tick_params()["labelbottom"]:
        below += LINE * SIZE + 5  # the numbers
    if legend := panel.get_legend():
        down = ScaledTranslation(0, -below / POINTS, figure.dpi_scale_trans)
        legend.set_bbox_to_anchor((0.0, 0.0), transform=panel.transAxes + down)
        lines = sum(text.get_text().count("\n") + 1 for text in legend.get_texts())
        below += (LINE * SMALL + 2.5) * lines + 6
    return above + below + 8


def noted(panel: Axes, room: float) -> float:
    """Moves its notes above a panel that has data; the height [points] that they need there."""
    notes = [text for text in panel.texts if text.get_gid() == NOTE]
    lines = [line for note in notes for line in note.get_text().split("\n")]
    text = fold("\n".join(lines), room, SMALL, style="italic")
    for note in notes:
        note.remove()
    look = {"fontsize": SMALL, "style": "italic"}
    if not panel.has_data():
        middle = {"ha": "center", "va": "center", "transform": panel.transAxes}
        panel.text(0.5, 0.5, text, **look, **middle)
        panel.set_aspect("auto")
    elif text:
        at = {"xycoords": "axes fraction", "xytext": (0, 3), "textcoords": "offset points"}
        panel.annotate(text, (0, 1), va="bottom", **look, **at)
        return LINE * SMALL * (text.count("\n") + 1) + 3
    return 0.0


def thin(axis: Axis) -> None:
    """Fewer numbers along an axis where they meet: as few as one."""
    if isinstance(axis.get_major_locator(), LogLocator):
        # Within less than a decade its ticks are as many as on any other axis.
        named = numbers(axis)
        apart = named[:1]
        for tick in named[1:]:
            if not tick.label1.get_window_extent().overlaps(apart[-1].label1.get_window_extent()):
                apart.append(tick)
        if len(apart) < len(named):
            axis.set_major_locator(FixedLocator([tick.get_loc() for tick in apart]))
        return
    for count in (3, 2, 1, 0):
        boxes = [tick.label1.get_window_extent() for tick in numbers(axis)]
        if not isinstance(axis.get_major_locator(), MaxNLocator):
            return
        if not any(one.overlaps(other) for one, other in pairwise(boxes)):
            return
        axis.set_major_locator(MaxNLocator(count) if count else FixedLocator([0.0]))


def numbers(axis: Axis) -> list[Tick]:
    """The ticks with a number. Of panels that share an axis one has them, and all share its ticks:
    without numbers there is nothing that meets.
    """
    ticks = [tick for tick in axis._update_ticks() if tick in axis.majorTicks]
    return [tick for tick in ticks if tick.label1.get_visible() and tick.label1.get_text()]


def place(figure: Figure) -> None:
    """Names of points go where nothing is drawn; those without such a place are left out."""
    for panel in figure.axes:
        panel.apply_aspect()
        thin(panel.xaxis)
        thin(panel.yaxis)
        names = [text for text in panel.texts if text.get_gid() == NAME]
        if not names:
            continue
        around = [panel.xaxis.label, panel.yaxis.label, panel._left_title]
        around += [*panel.get_xticklabels(), *panel.get_yticklabels(), *panel.texts]
        taken = [text.get_window_extent() for text in around if text not in names]
        marks = drawn(panel)
        for text in names:
            for dx, dy in PLACES:
                text.xyann = (dx, dy)
                text.set_ha("center" if dx == 0 else "right" if dx < 0 else "left")
                box = text.get_window_extent()
                inside = panel.bbox.x0 <= box.x0 and box.x1 <= figure.bbox.x1
                inside = inside and panel.bbox.y0 <= box.y0
                if inside and not box.count_contains(marks) and not box.count_overlaps(taken):
                    taken.append(box)
                    break
            else:
                text.remove()


def drawn(panel: Axes) -> np.ndarray:
    """(k, 2) [pixels] points on the lines and markers of a panel, close to one another, and corners
    of what is filled.
    """
    found = [np.zeros((0, 2))]
    for line in panel.lines:
        points = line.get_transform().transform(line.get_xydata())
        points = points[np.isfinite(points).all(axis=1)]
        if len(points) and line.get_marker() not in ("", "None", None):
            half = line.get_markersize() / 2 * panel.figure.dpi / POINTS
            found += [
                points + half * np.array(side) for side in ((1, 1), (1, -1), (-1, 1), (-1, -1))
            ]
        if len(points) > 1 and line.get_linestyle() != "None":
            longest = np.abs(np.diff(points, axis=0)).max()
            parts = np.linspace(0, 1, 2 + int(min(longest, 2000) / 3))[:, None, None]
            found.append((points[:-1] + parts * np.diff(points, axis=0)).reshape(-1, 2))
    for filled in panel.collections:
        to_pixels = filled.get_transform()
        found += [to_pixels.transform(path.vertices) for path in filled.get_paths()]
    return np.concatenate(found)
