"""What every table and figure promises, whichever are in the folders, on artefacts that the real
steps made.
"""

import re
from functools import cache
from importlib import import_module
from itertools import pairwise

import numpy as np
import pytest
from legible import faults
from plotly.graph_objects import Figure

from vibrom.report import figures, outputs, plots, tables
from vibrom.report.collection import Collection
from vibrom.report.scores import Scores

EXPERIMENTS = ["decay", "backbone"]  # one with a table of its own, one without
SCENES = {"cost": ["large"], "robustness": ["large"]}  # of the others: small and large
FAMILY = {
    name: family
    for family in outputs.families()
    for name in (
        *outputs.tables(family, EXPERIMENTS),
        *outputs.figures(family, SCENES.get(family, ["small", "large"])),
    )
}
TABLES = [name for family in outputs.families() for name in outputs.tables(family, EXPERIMENTS)]
FIGURES = [
    name
    for family in outputs.families()
    for name in outputs.figures(family, SCENES.get(family, ["small", "large"]))
]
UNITS = re.compile(r"\[[^\]]+\]")


@pytest.fixture(scope="module")
def of(real):
    """What a family is made from, and its scores."""

    def chosen(family: str) -> tuple[Collection, Scores]:
        scenes = SCENES.get(family, ["small", "large"])
        loaders = real.loaders.items()
        part = Collection({key: made for key, made in loaders if key.scene in scenes})
        return part, Scores.of(part)

    return cache(chosen)


@pytest.fixture(scope="module")
def drawn(of):
    """A figure, drawn once."""
    return cache(lambda name: figures.make(name, *of(FAMILY[name])))


@pytest.mark.parametrize("name", TABLES)
def test_a_table_has_its_columns_once_and_a_unit_on_every_number(of, name):
    made = tables.make(name, *of(FAMILY[name]))
    assert made.rows and len(made.printed.lines) == len(made.printed.marks)
    names = list(made.frame.columns)
    assert len(set(names)) == len(names) and "case" in names
    assert len(set(made.printed.head)) == len(made.printed.head)
    for column in made.columns:
        cells = made.frame[column.name]
        number = any(isinstance(cell, float) and np.isfinite(cell) for cell in cells)
        if column.heading and not column.whole and number and "unit" not in names:
            assert UNITS.search(column.heading), column


@pytest.mark.parametrize("name", TABLES)
def test_a_table_is_written_alike_twice_in_every_format(of, name):
    first, second = (tables.make(name, *of(FAMILY[name])) for _ in range(2))
    for form in outputs.FORMATS["tables"]:
        written = tables.render(first, form, "feed")
        assert written and written == tables.render(second, form, "feed")
        assert form == "csv" or b"feed" in written


@pytest.mark.parametrize("name", FIGURES)
def test_every_axis_says_what_it_shows_in_which_unit(drawn, name):
    figure = drawn(name)
    assert figure.axes
    for axes in figure.axes:
        if axes.get_label() != "<colorbar>":
            shared = axes.get_shared_y_axes().get_siblings(axes)  # one of them says it for all
            assert any(UNITS.search(one.get_ylabel()) for one in shared)
            assert UNITS.search(axes.get_xlabel())


@pytest.mark.parametrize("name", FIGURES)
def test_a_figure_is_legible_in_a_column_of_a_journal(drawn, name):
    assert faults(drawn(name)) == []


@pytest.mark.parametrize("name", FAMILY)
def test_a_run_with_nothing_but_its_structure_still_has_every_output(of, name):
    loaders = of(FAMILY[name])[0].loaders.items()
    left = Collection({key: made for key, made in loaders if key.name in ("structure", "rom")})
    if name in TABLES:
        assert tables.render(tables.make(name, left, Scores([])), "csv", "").startswith(b"case")
    else:
        figure = figures.make(name, left, Scores([]))
        titles = [axes.get_title(loc="left") for axes in figure.axes]
        words = [text.get_text() for axes in figure.axes for text in axes.texts]
        assert "".join(titles + words).strip() and faults(figure) == []


@pytest.mark.parametrize("kind", outputs.FORMATS)
def test_every_output_has_a_caption_and_a_place_of_its_own(kind):
    names = outputs._listed(kind)
    places = [constants["PLACE"] for constants in names.values()]
    assert all(first < second for first, second in pairwise(places))
    for name in names:
        title, paragraphs = outputs.caption(kind, name)
        assert title and paragraphs and "{{" not in "".join(paragraphs), name


@pytest.mark.parametrize(
    "name", sorted({outputs.drawing(name, ["small", "large"]).plug for name in FIGURES})
)
def test_every_plot_is_one_that_plotly_knows(real, name):
    """Its own check of every key and value; units on both axes; numbers in the alternative text."""
    module = import_module(f"vibrom.report.figures.{name}")
    if not hasattr(module, "plot"):
        pytest.skip("a drawing")
    assert module.plot.__doc__  # the caption
    looks = plots.looks(real.methods)
    for panel in module.plot(real, Scores.of(real)):
        made = panel.figure(looks)
        Figure(data=made["data"], layout=made["layout"])
        assert UNITS.search(panel.x) and UNITS.search(panel.y)
        assert not panel.series or re.search(r"\d", panel.seen.removeprefix(panel.title))


@pytest.mark.parametrize("name", FIGURES)
def test_every_drawing_says_its_numbers_to_those_who_cannot_see_it(of, name):
    plug, scene = outputs.drawing(name, ["small", "large"])
    module, (collection, scores) = import_module(f"vibrom.report.figures.{plug}"), of(FAMILY[name])
    if hasattr(module, "plot"):
        pytest.skip("a plot, whose panels are read out")
    words = module.seen(collection, scores, scene)
    assert words.startswith("No ") or re.search(r"\d", words), words
    bare = Collection({})
    assert "nan" not in words and isinstance(module.seen(bare, Scores([]), scene), str)
