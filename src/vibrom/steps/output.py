"""Artefacts -> results/tables/<name>.csv, .tex, .html or results/figures/<name>.svg, .pdf, .png."""

from collections.abc import Sequence
from importlib import import_module
from pathlib import Path

from vibrom.artefacts.files import write
from vibrom.report.collection import Collection
from vibrom.report.scores import Scores


def run(
    *,
    kind: str,
    artefacts: list[str],
    outputs: list[str],
    provenance: dict,
    scores: str | None = None,
    not_asked: Sequence[str] = (),
) -> None:
    """`kind`: tables or figures, the package below vibrom.report that makes them. `scores` are
    those of the run; without them, those of the artefacts. What an earlier run left and this one
    is `not_asked` for is removed: nothing would tell how old it is.
    """
    makers = import_module(f"vibrom.report.{kind}")
    collection = Collection.at(artefacts)
    known = Scores.of(collection) if scores is None else Scores.read(scores)
    for name in dict.fromkeys(Path(path).stem for path in outputs):
        made = makers.make(name, collection, known)
        for path in (path for path in outputs if Path(path).stem == name):
            form = Path(path).suffix.removeprefix(".")
            write(path, makers.render(made, form, provenance["source_digest"]))
    for path in map(Path, outputs):
        for name in not_asked:
            path.with_name(name + path.suffix).unlink(missing_ok=True)
