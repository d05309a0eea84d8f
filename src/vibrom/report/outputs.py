"""The tables and figures of a run, found by listing their files; nothing numerical is imported.

A table is a file in report/tables, a figure one in report/figures. Its docstring is its caption: a
title, an empty line, paragraphs. Constants say the rest: FAMILY, "models" or the name of a study;
PLACE, its place in reading order; EACH of a figure, one for the "run" or one for each "scene", and
DATA, where its numbers are. `plot` of a figure replaces it on the page (`report.plots`); without
one, `seen(collection, scores, scene) -> str` says its numbers to those who cannot see it.
ASKED names the experiment that it shows: scenes that do not ask it have no such figure, and a run
that does not has no such table. A figure with GLANCE stands near the top of the page. ALSO names
studies whose artefacts a table or figure needs besides those of its family. An experiment without a
table of its own has one of its scores.
"""

import ast
import re
from collections.abc import Callable, Iterable, Mapping
from functools import cache
from typing import NamedTuple

from vibrom.config import plugs, source
from vibrom.thesis.labels import CASES

FORMATS = {"tables": ("csv", "tex", "html"), "figures": ("svg", "pdf", "png")}
MODELS = "models"
NEEDED = {"tables": ("FAMILY", "PLACE"), "figures": ("FAMILY", "PLACE", "EACH", "DATA")}
SCORES = (
    "Median over seeds, smallest and largest in parentheses. Failed seeds are left out, and there "
    "is no median where as many failed as did not; the outcome says how the seeds ended."
)


class Drawing(NamedTuple):
    """A figure to be drawn."""

    plug: str
    scene: str | None  # None: of the whole run


class Caption(NamedTuple):
    """What stands below a table or a figure."""

    title: str
    paragraphs: tuple[str, ...]

    @property
    def rst(self) -> str:
        """As reStructuredText, for Snakemake's report."""
        return "\n\n".join([f"**{self.title}**", *self.paragraphs]) + "\n"

    @property
    def of_own_scenes(self) -> "Caption":
        """Without the thesis: its number of a table or figure, and sentences that name it."""
        title = re.sub(r"^(?:Table|Figure)s? [\d. to]+: ", "", self.title)
        left = (
            " ".join(part for part in re.split(r"(?<=\.) ", text) if "thesis" not in part.lower())
            for text in self.paragraphs
        )
        return Caption(title[0].upper() + title[1:], tuple(filter(None, left)))


@cache
def _listed(kind: str) -> dict[str, dict]:
    """Name -> constants of each table or figure, in reading order."""
    found = {
        name: plugs.constants(f"report/{kind}", name) for name in plugs.names(f"report/{kind}")
    }
    for name, constants in found.items():
        missing = [need for need in NEEDED[kind] if need not in constants]
        if missing:
            raise ValueError(f"report/{kind}/{name}.py: no {', '.join(missing)}; see {__name__}")
    return dict(sorted(found.items(), key=lambda item: (item[1]["PLACE"], item[0])))


def families() -> list[str]:
    """All families that have a table or a figure, in reading order."""
    every = [constants for kind in FORMATS for constants in _listed(kind).values()]
    return list(dict.fromkeys(constants["FAMILY"] for constants in every))


def tables(family: str, experiments: Iterable[str] | None = None) -> list[str]:
    """The tables of a family; where it is known which experiments a run asks, without those of
    other ones, and with those of the scores of experiments that have none.
    """
    every = {name: one for name, one in _listed("tables").items() if one["FAMILY"] == family}
    if experiments is None:
        return list(every)
    asked = list(experiments)
    own = [name for name, one in every.items() if one.get("ASKED") in (None, *asked)]
    return own + [name for name in asked if family == MODELS and not has_table(name)]


def has_table(name: str) -> bool:
    """Is there a file for this table?"""
    return name in _listed("tables")


def figures(
    family: str,
    scenes: Iterable[str],
    recorded: Iterable[str] = (),
    asked: Callable[[str], Iterable[str]] | None = None,
) -> dict[str, Drawing]:
    """The figures of a family over these scenes by name: <plug>, or <plug>_<scene>. With the
    constant RECORDED they are of `recorded` scenes only, or of no such scene where it is false;
    with ASKED of scenes in which that experiment is `asked`, where that is known.
    """
    found: dict[str, Drawing] = {}
    scenes, measured = list(scenes), set(recorded)
    for plug, constants in _listed("figures").items():
        if constants["FAMILY"] == family:
            shown: list[str | None] = [
                scene for scene in scenes if constants.get("RECORDED") in (None, scene in measured)
            ]
            if asked is not None and (name := constants.get("ASKED")):
                shown = [scene for scene in shown if name in asked(scene)]
            if constants["EACH"] == "run" and shown:
                shown = [None]
            for scene in shown:
                name = plug if scene is None else f"{plug}_{scene}"
                if name in found:
                    raise ValueError(f"two figures are called {name}; rename the scene {scene}")
                found[name] = Drawing(plug, scene)
    return found


def drawing(name: str, scenes: Iterable[str]) -> Drawing:
    """The figure of this name, whichever of the scenes are recorded."""
    scenes = list(scenes)
    found = {
        key: made
        for family in families()
        for recorded in (scenes, ())
        for key, made in figures(family, scenes, recorded).items()
    }
    if name not in found:
        raise ValueError(f"figure {name!r}: unknown; choose from {', '.join(found)}")
    return found[name]


def also(family: str) -> list[str]:
    """The other studies that the tables and figures of a family need."""
    every = [constants for kind in FORMATS for constants in _listed(kind).values()]
    named = [item.get("ALSO", ()) for item in every if item["FAMILY"] == family]
    return list(dict.fromkeys(study for studies in named for study in studies))


def at_a_glance(plug: str) -> bool:
    """Does this figure stand near the top of the page?"""
    return bool(_listed("figures")[plug].get("GLANCE", False))


def family(kind: str, name: str) -> str:
    """Of a table or a figure's file; that of an experiment's scores is models."""
    return _listed(kind).get(name, {}).get("FAMILY", MODELS)


def data(plug: str, scenes: Iterable[str]) -> list[str]:
    """Files with the numbers of a figure, below the folder of results: its constant DATA names
    tables, or artefacts as `{scene}/full_order/release.nc`.
    """
    found = [
        name.format(scene=scene) if "/" in name else f"tables/{name}.csv"
        for name in _listed("figures")[plug]["DATA"]
        for scene in scenes
    ]
    return list(dict.fromkeys(found))


def modules(kind: str, family: str) -> list[str]:
    """The files behind the tables or figures of a family, as modules below vibrom."""
    chosen = [name for name, constants in _listed(kind).items() if constants["FAMILY"] == family]
    return [f"report.{kind}.{name}" for name in chosen]


@cache
def caption(kind: str, name: str) -> Caption:
    """The caption of a table or of a figure's file; that of scores quotes the experiment's."""
    if kind == "tables" and not has_table(name):
        about = _docstring("experiments", name)[:1]
        return Caption(f"Scores of the experiment {name}", (*about, SCORES))
    title, *paragraphs = _docstring(f"report/{kind}", name) or [""]
    if not title or not paragraphs:
        cure = "its docstring needs a title, an empty line and text"
        raise ValueError(f"report/{kind}/{name}.py: no caption; {cure}")
    return Caption(title.removesuffix("."), tuple(paragraphs))


def captions(
    names: Mapping[str, Iterable[str]], scenes: Iterable[str] = CASES
) -> dict[str, Caption]:
    """`tables/<name>` or `figures/<plug>` -> caption, of the names of each kind, in a run of these
    scenes.
    """
    made = {f"{kind}/{name}": caption(kind, name) for kind in names for name in names[kind]}
    if set(scenes) & set(CASES):
        return made
    return {place: one.of_own_scenes for place, one in made.items()}


def _docstring(folder: str, name: str) -> list[str]:
    """The paragraphs of a module's docstring, each on one line."""
    path = source.PACKAGE / folder / f"{name}.py"
    text = ast.get_docstring(ast.parse(path.read_bytes())) or ""
    return [" ".join(block.split()) for block in text.split("\n\n") if block.strip()]
