"""The report: one HTML file with every table, every figure and every failure, that needs nothing
else to be read.
"""

from __future__ import annotations

import base64
import json
from collections.abc import Mapping, Sequence

import pandas as pd
from markupsafe import Markup

from vibrom.report import outputs
from vibrom.report.collection import FULL_ORDER, Collection, scalar
from vibrom.report.outputs import Caption
from vibrom.report.table import Table, render, resource, to_html
from vibrom.thesis import published as thesis
from vibrom.thesis.labels import label

__all__ = ["compose", "image", "plain", "resource"]
HEAVY = 400_000  # bytes: a figure above this goes in as pixels


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
    for scene, model in collection.models[: 1 + len(collection.methods)]:
        name = "structure" if model == FULL_ORDER else "rom"
        dataset = next(iter(collection.every(scene, model, name)), None)
        if dataset is not None:
            digest = str(scalar(dataset, "source_digest", "unknown"))
            rows.append((label(model), name, digest))
            versions |= json.loads(str(scalar(dataset, "versions", "{}")))
    frame = pd.DataFrame(rows, columns=["Model", "Artefact", "Source digest"])
    return frame, dict(sorted(versions.items()))


def compose(
    *,
    collection: Collection,
    headline: dict[str, pd.DataFrame],
    tables: Sequence[Table],
    figures: Mapping[str, dict[str, bytes]],
    captions: Mapping[str, Caption],
    failures: Table,
    provenance: dict,
) -> str:
    """The page; `figures` are the bytes of each by format, in reading order, `captions` by
    `tables/<name>` and `figures/<plug>`.
    """
    digests, versions = sources(collection)
    drawings = {name: outputs.drawing(name, collection.scenes) for name in figures}
    shown = [
        {
            "name": name,
            "scene": scene,
            "caption": captions[f"figures/{plug}"],
            "image": image(figures[name]),
            "glance": outputs.at_a_glance(plug),
        }
        for name, (plug, scene) in drawings.items()
    ]
    return render(
        "page.html.j2",
        scenes=collection.scenes,
        methods=[label(method) for method in collection.methods],
        seeds=len({key.seed for key in collection.loaders} - {None}),
        headline=[(title, plain(frame)) for title, frame in headline.items()],
        glance=[figure for figure in shown if figure["glance"]],
        figures=[figure for figure in shown if not figure["glance"]],
        tables=[
            {
                "name": table.name,
                "caption": captions[f"tables/{table.name}"],
                "html": to_html(table),
            }
            for table in tables
        ],
        failures=to_html(failures) if failures.rows else None,
        digests=plain(digests),
        versions=versions | json.loads(provenance.get("versions", "{}")),
        digest=provenance.get("source_digest", "unknown"),
        thesis=thesis.SOURCE,
    )
