"""How figures look: one style sheet, a look for each method that survives black and white,
repeatable files.
"""

import hashlib
import io
import re
from collections.abc import Iterable

import matplotlib
from matplotlib.figure import Figure

from vibrom.report.drawing import layout
from vibrom.thesis.labels import KNOWN

# Whatever the user's own style sheet says, as text set by LaTeX.
DEFAULTS = {
    key: value for key, value in matplotlib.rcParamsDefault.items() if not key.startswith("backend")
}
STYLE = DEFAULTS | {
    "font.family": "DejaVu Sans",
    "font.size": layout.SIZE,
    "axes.titlesize": layout.SIZE,
    "axes.titlelocation": "left",
    "axes.titleweight": "bold",
    "axes.labelsize": layout.SIZE,
    "xtick.labelsize": layout.SMALL,
    "ytick.labelsize": layout.SMALL,
    "legend.fontsize": layout.SMALL,
    "legend.frameon": False,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.linewidth": 0.7,
    "axes.edgecolor": "0.3",
    "axes.grid": True,
    "grid.color": "0.9",
    "grid.linewidth": 0.6,
    "axes.axisbelow": True,
    "axes.formatter.useoffset": False,
    "xtick.major.width": 0.7,
    "ytick.major.width": 0.7,
    "lines.linewidth": 1.1,
    "figure.constrained_layout.use": True,
    "figure.dpi": 220,
    "text.hinting": "no_hinting",  # or words are as wide as the pixels make them
    "svg.hashsalt": "vibrom",
    "svg.fonttype": "path",
    "savefig.facecolor": "white",
    "path.simplify_threshold": 0.3,
}

LAID_OUT = STYLE | {"figure.constrained_layout.use": False}  # or every file is drawn twice

# The reference in every comparison: wide and pale, so that a thin dark line on top of it stays
# visible without colour.
TRUE = {"color": "0.72", "linewidth": 2.2, "linestyle": "-", "solid_capstyle": "round"}
PREDICTED = {"color": "#8a2a0b", "linewidth": 0.8, "linestyle": (0, (5, 1.2))}
FULL_ORDER = {"color": "black", "linewidth": 2.4, "linestyle": "-", "alpha": 0.85}

COLOURS = ("#0072b2", "#d55e00", "#009e73", "#aa3377", "#e69f00", "#56a0d3", "#6b5b2a", "#555555")
DASHES = (
    (0, ()),
    (0, (5, 1.5)),
    (0, (1.2, 1.2)),
    (0, (6, 1.5, 1.2, 1.5)),
    (0, (3, 1, 1, 1, 1, 1)),
    (0, (9, 2)),
    (0, (2.5, 2)),
)
MARKERS = ("o", "s", "^", "D", "v", "P", "X", "<", ">")

# Path coordinates are rounded to a hundredth of a point, which nobody sees and which halves the
# files.
PATH, LONG = re.compile(rb' d="[^"]*"'), re.compile(rb"(\.\d\d)\d+")


LOOKS = len(DASHES) * len(MARKERS)  # looks with a dash and marker of their own: 7 and 9 are coprime


def look(index: int, **changes) -> dict:
    """Line number `index`: its own colour, dash and marker, hollow and then filled, so that markers
    without lines are told apart without colour, too.
    """
    colour = COLOURS[index % len(COLOURS)]
    return {
        "color": colour,
        "linestyle": DASHES[index % len(DASHES)],
        "linewidth": 1.1,
        "marker": MARKERS[index % len(MARKERS)],
        "markersize": 4.2,
        "markerfacecolor": colour if index // len(MARKERS) % 2 else "white",
        "markeredgewidth": 0.9,
    } | changes


def looks(methods: Iterable[str]) -> dict[str, dict]:
    """The line of each method, alike in every figure and run.

    Those that the thesis's labels list have fixed ones. Any other is found by a hash of its name;
    of two that meet, the later one in the alphabet takes the next that is free.
    """
    places = {method: index for index, method in enumerate(KNOWN)}
    for method in sorted(set(methods) - set(KNOWN)):
        index = int(hashlib.sha256(method.encode()).hexdigest(), 16)
        span = LOOKS - len(KNOWN)
        order = (len(KNOWN) + (index + step) % span for step in range(span))
        places[method] = next((at for at in order if at not in places.values()), index % LOOKS)
    return {method: look(places[method]) for method in methods}


def render(figure: Figure, form: str, digest: str = "unknown") -> bytes:
    """The figure as `svg`, `pdf` or `png`; no dates, so that equal figures are equal files."""
    source = f"vibrom, source digest {digest}"
    metadata = {
        "svg": {"Date": None, "Creator": "vibrom", "Description": source},
        "pdf": {
            "CreationDate": None,
            "Creator": "vibrom",
            "Producer": "matplotlib",
            "Subject": source,
        },
        "png": {"Software": "vibrom", "Description": source},
    }[form]
    content = io.BytesIO()
    with matplotlib.rc_context(LAID_OUT):
        figure.savefig(content, format=form, metadata=metadata, dpi="figure")
    return (
        PATH.sub(lambda path: LONG.sub(rb"\1", path[0]), content.getvalue())
        if form == "svg"
        else content.getvalue()
    )
