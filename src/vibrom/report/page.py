"""The report: one HTML file with the answer, every table, every plot and every failure, that needs
nothing else to be read. Templates, scripts and the style sheet lie in the folder `templates`.
"""

from __future__ import annotations

import base64
import gzip
import io
import json
import re
from collections.abc import Mapping, Sequence
from functools import cache, partial
from importlib import import_module
from importlib.resources import files
from textwrap import shorten
from types import ModuleType
from typing import Any

from markupsafe import Markup
from PIL import Image

from vibrom.report import answer, differences, motion, outputs, plots, sentences
from vibrom.report.collection import FULL_ORDER, Collection, scalar
from vibrom.report.columns import METHOD, Column, number
from vibrom.report.outputs import Caption
from vibrom.report.scores import Scores
from vibrom.report.table import Table, printed, render, resource, table, to_html
from vibrom.thesis import published as thesis
from vibrom.thesis.labels import label

BREATH = 280  # letters of an alternative text: what is read from a figure stands beside it
HEAVY = 200_000  # bytes: a drawing above this goes in as pixels
COLOURS = 64  # of such pixels
# A table stands in two columns on paper where its longest words fit half a page, and its lines are
# not much longer than that.
WORDS, LINE = 74, 135  # letters; a column counts one more, and two in a line
SECTIONS = {  # a family of figures and tables, or a template -> title
    "cost": "Accuracy and cost",
    "motion": "The beam moves",
    "models": "Decays, forced runs, response curves, backbones",
    "ablation": "Ablation: what each effect is worth",
    "robustness": "Robustness: far from the training data",
    "trust": "Trust: how well models obey the equations of motion",
}
LAST = {
    "differences": "Where the thesis and we differ, and why",
    "failures": "Failures",
    "made": "How it was made",
}
TEMPLATES = ("motion", *LAST)
SCRIPTS = ("plots.js", "motion.js", "tables.js")
MADE_BY = (METHOD, Column("artefact", "Artefact"), Column("source_digest", "Source digest"))
# Paths of the markers of the legend, about their middle.
MARKERS = {
    "o": "M-3.4 0a3.4 3.4 0 1 0 6.8 0a3.4 3.4 0 1 0 -6.8 0z",
    "s": "M-3-3h6v6h-6z",
    "^": "M0-4L3.6 2.6h-7.2z",
    "D": "M0-4.2L4.2 0L0 4.2L-4.2 0z",
    "v": "M0 4L3.6-2.6h-7.2z",
    "P": "M-1.3-4h2.6v2.7h2.7v2.6h-2.7v2.7h-2.6v-2.7h-2.7v-2.6h2.7z",
    "X": "M-4-2.2L-2.2-4L0-1.8L2.2-4L4-2.2L1.8 0L4 2.2L2.2 4L0 1.8L-2.2 4L-4 2.2L-1.8 0z",
    "<": "M-4 0L2.6-3.6v7.2z",
    ">": "M4 0L-2.6-3.6v7.2z",
}


@cache
def plotly() -> str:
    """The code of Plotly as its package brings it, compressed, as text."""
    code = (files("plotly") / "package_data" / "plotly.min.js").read_bytes()
    return base64.b64encode(gzip.compress(code, 9, mtime=0)).decode()


def image(formats: Mapping[str, bytes]) -> str:
    """A drawing as a data address: vectors, unless they are too heavy."""
    if "svg" in formats and (len(formats["svg"]) <= HEAVY or "png" not in formats):
        kind, content = "image/svg+xml", formats["svg"]
    else:
        kind, content = "image/png", fewer_colours(formats["png"])
    return f"data:{kind};base64,{base64.b64encode(content).decode()}"


def fewer_colours(png: bytes) -> bytes:
    """The same pixels in a palette: a third of the bytes, and no difference to the eye."""
    made = io.BytesIO()
    with Image.open(io.BytesIO(png)) as picture:
        picture.convert("RGB").quantize(COLOURS).save(made, "PNG", optimize=True)
    return made.getvalue()


def narrow(one: Table) -> bool:
    """Does it stand in two columns on paper?"""
    columns = list(zip(one.printed.head, *one.printed.lines))
    words = sum(1 + max(map(len, re.split("[ _]", " ".join(column)))) for column in columns)
    line = sum(2 + max(map(len, column[1:]), default=0) for column in columns)
    return words <= WORDS and line <= LINE


def data_block(values: Any) -> Markup:
    """For a script element, which ends at the first `</`."""
    text = json.dumps(values, allow_nan=False, separators=(",", ":"))
    return Markup(text.replace("</", "<\\/"))


def sources(collection: Collection) -> tuple[Table, dict[str, str], dict[str, Any]]:
    """Source digests of the artefacts behind the report, the versions of all packages that made
    them, and the hardware of the studies.
    """
    rows, versions, hardware = [], {}, {}
    for scene, model in collection.models[: 1 + len(collection.methods)]:
        name = "structure" if model == FULL_ORDER else "rom"
        dataset = next(iter(collection.every(scene, model, name)), None)
        if dataset is not None:
            digest = str(scalar(dataset, "source_digest", "unknown"))
            rows.append({"method": model, "artefact": name, "source_digest": digest})
            versions |= json.loads(str(scalar(dataset, "versions", "{}")))
    for key in collection.loaders:
        if key.name in outputs.families() and not hardware:
            dataset = collection.find(*key[:2], key.name, key.seed)
            hardware = json.loads(str(scalar(dataset, "hardware", "{}")))
    return (
        table("digests", MADE_BY, rows, partial(printed, marked=lambda row: "")),
        dict(sorted(versions.items())),
        hardware,
    )


def swatch(look: Mapping[str, Any]) -> dict[str, str]:
    """Line and marker of a method in the row of buttons."""
    lengths = "" if isinstance(look["linestyle"], str) else look["linestyle"][1]
    return {
        "color": look["color"],
        "dash": ",".join(f"{1.6 * part:g}" for part in lengths),
        "path": MARKERS[look["marker"]],
        "fill": "var(--paper)" if look["markerfacecolor"] == "white" else look["color"],
    }


class Figures:
    """The figures of the page: plots where a figure's file has them, else the drawings."""

    def __init__(self, collection: Collection, scores: Scores, captions: Mapping[str, Caption]):
        self.collection, self.scores, self.captions = collection, scores, captions
        self.looks = plots.looks(self._methods())
        self.data: dict[str, list[dict]] = {}  # what the page's script draws

    def _methods(self) -> list[str]:
        """Of the run, then those that only a study has."""
        studied = [
            str(name)
            for scene in self.collection.scenes
            if (found := self.collection.find(scene, FULL_ORDER, "cost_reduced")) is not None
            for name in found["model"].values
        ]
        return list(dict.fromkeys([*self.collection.methods, *studied]))

    def block(self, plug: str, drawn: Mapping[str | None, dict[str, bytes]]) -> dict[str, Any]:
        """One figure; `drawn`: scene, or None of the whole run -> its formats."""
        module = import_module(f"vibrom.report.figures.{plug}")
        made = {"name": plug, "caption": self.captions[f"figures/{plug}"], "images": []}
        if hasattr(module, "plot") and (panels := module.plot(self.collection, self.scores)):
            self.data[plug] = [panel.figure(self.looks) for panel in panels]
            made |= {
                "caption": plot_caption(made["caption"], module.plot.__doc__),
                "panels": [panel.short for panel in panels],
                "words": [panel.seen for panel in panels],
                "switch": any(panel.switch for panel in panels),
                "notes": [
                    f"{panel.title}: {' '.join(panel.notes)}" for panel in panels if panel.notes
                ],
            }
        else:
            made["images"] = [
                {"address": image(formats), "short": self.short(plug, scene)}
                for scene, formats in drawn.items()
            ]
            made["words"] = [self.seen(module, plug, scene) for scene in drawn]
        half = len(made.get("panels", [])) <= 2 and len(made["images"]) <= 1  # of a page of paper
        return made | {"half": half, "links": self.links(plug, list(drawn))}

    def short(self, plug: str, scene: str | None) -> str:
        """What a drawing shows, in a breath: its title, and the first sentences of its caption."""
        caption = self.captions[f"figures/{plug}"]
        head = f"{caption.title}{f', case {scene}' if scene else ''}. "
        return shorten(head + " ".join(caption.paragraphs), BREATH, placeholder=" …")

    def seen(self, module: ModuleType, plug: str, scene: str | None) -> str:
        """What is read from a drawing, from its numbers where its file says them."""
        said = " ".join(self.captions[f"figures/{plug}"].paragraphs)
        if hasattr(module, "seen"):
            said = module.seen(self.collection, self.scores, scene)
        return f"Case {scene}. {said}" if scene else said

    def links(self, plug: str, scenes: Sequence[str | None]) -> list[tuple[str, str]]:
        """Words and addresses of a figure's data and of its drawings for print."""
        names = [plug if scene is None else f"{plug}_{scene}" for scene in scenes]
        data = [
            address
            for address in outputs.data(plug, self.collection.scenes)
            if address.removesuffix(".csv") in self.captions
            or (address.endswith(".nc") and self.collection.has(address))
        ]
        return [
            *((f"data: {address}", address) for address in data),
            *((f"for print: {name}.pdf", f"figures/{name}.pdf") for name in names),
        ]


def sections(figures: list[dict], tables: list[dict], silent: Sequence[str]) -> list[dict]:
    """In reading order, each with what it holds and its contents, but those that are silent."""
    studies = {name: f"Study: {name.replace('_', ' ')}" for name in outputs.families()}
    made = []
    for name, title in {**SECTIONS, **(studies | SECTIONS), **LAST}.items():
        mine = {
            "figures": [one for one in figures if one["section"] == name],
            "tables": [one for one in tables if one["family"] == name],
        }
        if name in silent or not (any(mine.values()) or name in TEMPLATES):
            continue
        entries = [
            (f"{kind[:-1]}-{one['name']}", one["caption"].title)
            for kind, found in mine.items()
            for one in found
        ]
        template = f"{name}.html.j2" if name in TEMPLATES else None
        made.append({"id": name, "title": title, "entries": entries, "template": template, **mine})
    return made


def compose(
    *,
    collection: Collection,
    scores: Scores,
    tables: Sequence[Table],
    figures: Mapping[str, dict[str, bytes]],
    captions: Mapping[str, Caption],
    failures: Table,
    provenance: dict,
) -> str:
    """The page; `figures` are the bytes of each by format, in reading order, `captions` by
    `tables/<name>` and `figures/<plug>`.
    """
    digests, versions, hardware = sources(collection)
    headline = answer.of(collection, scores)
    drawn: dict[str, dict[str | None, dict[str, bytes]]] = {}
    for name, formats in figures.items():
        plug, scene = outputs.drawing(name, collection.scenes)
        drawn.setdefault(plug, {})[scene] = formats
    made = Figures(collection, scores, captions)
    blocks = [
        made.block(plug, formats) | {"section": section_of(plug)} for plug, formats in drawn.items()
    ]
    listed = [
        {
            "name": one.name,
            "caption": captions[f"tables/{one.name}"],
            "html": to_html(one),
            "narrow": narrow(one),
            "family": outputs.family("tables", one.name),
            "link": f"tables/{one.name}.csv",
        }
        for one in tables
        if one.rows  # of what no scene of the run asks there are none
    ]
    points = differences.points(collection, scores)
    return render(
        "page.html.j2",
        answer=headline,
        sentences=sentences.of(headline),
        remarks=sentences.remarks(headline, collection),
        seeds=len({key.seed for key in collection.loaders} - {None}),
        methods=[(name, label(name), swatch(made.looks[name])) for name in collection.methods],
        sections=sections(blocks, listed, () if points else ("differences",)),
        plots=data_block(made.data),
        motion=data_block(motion.scenes(collection, scores)),
        plotly=plotly() if made.data else "",
        scripts=[Markup(resource(name)) for name in SCRIPTS],
        differences=points,
        failures=to_html(failures) if failures.rows else None,
        digests=to_html(digests),
        hardware=hardware,
        versions=versions | json.loads(provenance.get("versions", "{}")),
        digest=provenance.get("source_digest", "unknown"),
        thesis=thesis.SOURCE,
        label=label,
        number=number,
    )


def plot_caption(caption: Caption, docstring: str | None) -> Caption:
    """Title of the figure, and what `plot` says of itself."""
    paragraphs = [" ".join(part.split()) for part in (docstring or "").split("\n\n")]
    return Caption(caption.title, tuple(part for part in paragraphs if part))


def section_of(plug: str) -> str:
    """Figures at a glance stand first, others with their family."""
    return "cost" if outputs.at_a_glance(plug) else outputs.family("figures", plug)
