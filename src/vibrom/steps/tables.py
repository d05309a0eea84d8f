"""Artefacts and, where reduced models took part, scores.csv -> results/tables/<name>.csv, .tex and
.html.
"""

from pathlib import Path

from vibrom.report import presentation
from vibrom.report import tables as contract
from vibrom.report.page import standalone
from vibrom.steps._files import collection, scores_at, write


def run(
    *,
    artefacts: list[str],
    tables: list[str],
    scores: str | None = None,
    provenance: dict | None = None,
) -> None:
    runs, values = collection(artefacts), scores_at(scores)
    digest = (provenance or {}).get("source_digest", "unknown")
    frames = {
        name: contract.build(name, runs, values)
        for name in dict.fromkeys(Path(path).stem for path in tables)
    }
    for path in tables:
        name, form = Path(path).stem, Path(path).suffix
        if form == ".csv":
            write(path, frames[name].to_csv(index=False, lineterminator="\n"))
        elif form == ".tex":
            write(
                path,
                f"% vibrom table {name}, source digest {digest}\n{presentation.to_tex(name, frames[name])}",
            )
        elif form == ".html":
            write(
                path,
                standalone(f"vibrom: {name}", presentation.to_html(name, frames[name]), digest),
            )
        else:
            raise ValueError(
                f"{path}: a table is written as .csv, .tex or .html; rename the output"
            )
