"""The report: one HTML file with every table, every figure and every failure, that needs nothing
else to be read.
"""

import base64
import json
from importlib.resources import files

import pandas as pd
from jinja2 import Environment
from markupsafe import Markup

from vibrom.report import names
from vibrom.report.captions import Caption
from vibrom.report.collection import FULL_ORDER, UNSEEDED, Collection, scalar
from vibrom.thesis import published as thesis

HEAVY = 400_000  # bytes: a figure above this goes in as pixels


def resource(name: str) -> str:
    return (files("vibrom.report") / name).read_text(encoding="utf-8")


def render(template: str, **values) -> str:
    environment = Environment(autoescape=True, trim_blocks=True, lstrip_blocks=True)
    return environment.from_string(resource(template)).render(
        css=Markup(resource("page.css")), **values
    )


def standalone(title: str, table: str, digest: str) -> str:
    """One table as a page of its own."""
    return render("table.html.j2", title=title, table=Markup(table), digest=digest)


def fragment(html: str) -> Markup:
    """The `<table>` of a page that `standalone` made."""
    return Markup(html[html.index("<table") : html.rindex("</table>") + len("</table>")])


def image(formats: dict[str, bytes]) -> str:
    """A figure as a data address: vectors, unless they are too heavy."""
    light = "svg" in formats and (len(formats["svg"]) <= HEAVY or "png" not in formats)
    form, kind = ("svg", "image/svg+xml") if light else ("png", "image/png")
    return f"data:{kind};base64,{base64.b64encode(formats[form]).decode()}"


def plain(frame: pd.DataFrame) -> Markup:
    """A table of text cells."""
    return Markup(frame.to_html(index=False, border=0, classes="data", escape=True, justify="left"))


def sources(collection: Collection) -> tuple[pd.DataFrame, dict[str, str]]:
    """Source digests of the artefacts behind the report, and the versions of all packages that made
    them.
    """
    rows, versions = [], {}
    for scene in collection.scenes[:1]:
        for model in [FULL_ORDER, *collection.methods]:
            name = "structure" if model == FULL_ORDER else "rom"
            seeds = [UNSEEDED] if model == FULL_ORDER else collection.seeds(scene, model)
            dataset = collection.find(scene, model, name, seeds[0]) if seeds else None
            if dataset is not None:
                rows.append(
                    (thesis.label(model), name, str(scalar(dataset, "source_digest", "unknown")))
                )
                versions |= json.loads(str(scalar(dataset, "versions", "{}")))
    return pd.DataFrame(rows, columns=["Model", "Artefact", "Source digest"]), dict(
        sorted(versions.items())
    )


def compose(
    *,
    collection: Collection,
    headline: dict[str, pd.DataFrame],
    tables: dict[str, str],
    figures: dict[str, dict[str, bytes]],
    captions: dict[str, Caption],
    hard: pd.DataFrame,
    provenance: dict,
) -> str:
    """The page; `tables` are the HTML files of the tables, `figures` the bytes of each figure by
    format, `captions` by `tables/<name>` and `figures/<group>`.
    """

    def entry(name: str, **content) -> dict:
        kind = "tables" if "table" in content else "figures"
        stem, scene = (name, None) if kind == "tables" else names.split(name)
        caption = captions.get(f"{kind}/{stem}", Caption(name.replace("_", " "), ()))
        return {
            "name": name,
            "title": caption.title,
            "scene": scene,
            "paragraphs": caption.paragraphs,
            **content,
        }

    digests, versions = sources(collection)
    versions |= json.loads(provenance.get("versions", "{}"))
    shown = [
        entry(name, image=image(figures[name]))
        for name in names.figures(collection.scenes)
        if name in figures
    ]
    return render(
        "page.html.j2",
        scenes=collection.scenes,
        methods=[thesis.label(method) for method in collection.methods],
        seeds=len({key[2] for key in collection.loaders if key[2] != UNSEEDED}),
        headline=[(title, plain(frame)) for title, frame in headline.items()],
        glance=[figure for figure in shown if "cost" in figure["name"].split("_")],
        figures=[figure for figure in shown if "cost" not in figure["name"].split("_")],
        tables=[
            entry(name, table=fragment(tables[name])) for name in names.tables() if name in tables
        ],
        hard=plain(hard) if len(hard) else None,
        digests=plain(digests),
        versions=versions,
        digest=provenance.get("source_digest", "unknown"),
        thesis=thesis.SOURCE,
    )
