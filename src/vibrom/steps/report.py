"""Artefacts, figures and captions -> results/report.html."""

from pathlib import Path

from vibrom.artefacts.files import write
from vibrom.report import failures, page, tables
from vibrom.report.collection import Collection
from vibrom.report.outputs import Caption
from vibrom.report.scores import Scores


def run(
    *,
    artefacts: list[str],
    scores: str,
    figures: list[str],
    tables_shown: list[str],
    captions: dict[str, list],
    report: str,
    provenance: dict,
) -> None:
    """`tables_shown` in reading order; `captions`: tables/<name> or figures/<plug> -> title,
    paragraphs.
    """
    collection = Collection.at(artefacts)
    known = Scores.read(scores)
    made = {name: tables.make(name, collection, known) for name in tables_shown}
    pictures: dict[str, dict[str, bytes]] = {}
    for path in map(Path, figures):
        if path.suffix in (".svg", ".png"):
            pictures.setdefault(path.stem, {})[path.suffix.removeprefix(".")] = path.read_bytes()
    content = page.compose(
        collection=collection,
        scores=known,
        tables=list(made.values()),
        figures=pictures,
        captions={name: Caption(title, tuple(text)) for name, (title, text) in captions.items()},
        failures=failures.build(collection, known),
        provenance=provenance,
    )
    write(report, content)
