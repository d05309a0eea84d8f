"""What is wrong with a figure as it is printed: small letters, words cut off or over one another,
words over the data, a figure that is too wide or too tall.
"""

from itertools import combinations

import numpy as np

LEAST = 6.0  # [points] of letters: what journals ask for at least
COLUMN = 90 / 25.4  # [inches], the widest column of a journal with two
PAGE = 247 / 25.4  # [inches], an A4 page with margins of 25 mm
TOUCH = (
    1.0  # [points] that boxes may reach into one another: a line's box is higher than its letters
)


def faults(figure) -> list[str]:
    """One line each."""
    if figure.get_layout_engine() is None:  # it was laid out; drawing puts its words in place
        figure.draw_without_rendering()
    width, height = figure.get_size_inches()
    found = [f"{width:.2f} inches wide"] if width > COLUMN else []
    found += [f"{height:.2f} inches tall"] if height > PAGE else []
    point, shown = figure.dpi / 72, texts(figure)
    boxes = {text: text.get_window_extent() for text in shown}
    for text, box in boxes.items():
        said = text.get_text()
        if text.get_fontsize() < LEAST:
            found.append(f"{said!r}: {text.get_fontsize()} points")
        if not (-point <= box.x0 and box.x1 <= figure.bbox.x1 + point):
            found.append(f"{said!r}: outside, to the side")
        if not (-point <= box.y0 and box.y1 <= figure.bbox.y1 + point):
            found.append(f"{said!r}: outside, above or below")
    for (one, a), (other, b) in combinations(boxes.items(), 2):
        across = min(a.x1, b.x1) - max(a.x0, b.x0)
        along = min(a.y1, b.y1) - max(a.y0, b.y0)
        if across > TOUCH * point and along > TOUCH * point:
            found.append(f"{one.get_text()!r} over {other.get_text()!r}")
    return found + [line for panel in figure.axes for line in covered(panel, boxes)]


def texts(figure) -> list:
    """All that is written in it."""
    found = [*figure.texts, *(text for legend in figure.legends for text in legend.get_texts())]
    found += [figure._suptitle] if figure._suptitle else []
    for panel in figure.axes:
        legend = panel.get_legend()
        found += [*panel.texts, panel.title, panel._left_title, panel._right_title]
        found += legend.get_texts() if legend else []
        for axis in (panel.xaxis, panel.yaxis):
            ticks = axis._update_ticks()  # those between the ends of the axis
            found += [axis.label, axis.get_offset_text(), *(tick.label1 for tick in ticks)]
    return [text for text in found if text.get_visible() and text.get_text().strip()]


def covered(panel, boxes) -> list[str]:
    """Words over lines or markers of their panel."""
    words = [text for text in panel.texts if text in boxes]
    found = []
    for line in panel.lines if words else []:
        points = line.get_transform().transform(line.get_xydata())
        points = points[np.isfinite(points).all(axis=1)]
        if line.get_linestyle() != "None" and len(points) > 1:
            longest = np.abs(np.diff(points, axis=0)).max()
            steps = np.linspace(0, 1, 2 + int(min(longest, 5000) / 2))[:, None, None]
            points = (points[:-1] + steps * np.diff(points, axis=0)).reshape(-1, 2)
        inside = panel.bbox.frozen()
        for text in words:
            box = boxes[text]
            hit = (points > [max(box.x0, inside.x0), max(box.y0, inside.y0)]).all(axis=1)
            hit &= (points < [min(box.x1, inside.x1), min(box.y1, inside.y1)]).all(axis=1)
            if hit.any():
                found.append(f"{text.get_text()!r} over a line")
    return found
