"""One file a figure, each with `draw(collection, scores, scene) -> Figure`; scene None stands for
the whole run. `vibrom.report.outputs` says what else is in such a file.
"""

from importlib import import_module

import matplotlib
from matplotlib.figure import Figure

from vibrom.report import outputs
from vibrom.report.collection import Collection
from vibrom.report.drawing import layout, style
from vibrom.report.scores import Scores


def make(name: str, collection: Collection, scores: Scores) -> Figure:
    """The figure of this name, as wide as a column, laid out once for all formats."""
    plug, scene = outputs.drawing(name, collection.scenes)
    draw = import_module(f"{__name__}.{plug}").draw
    with matplotlib.rc_context(style.STYLE):
        figure = draw(collection, scores, scene)
        layout.finish(figure)
        figure.get_layout_engine().execute(figure)
        layout.place(figure)
    with matplotlib.rc_context(style.LAID_OUT):
        figure.set_layout_engine(None)
    return figure


render = style.render  # (figure, form, digest) -> bytes
