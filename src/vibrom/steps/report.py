"""Tables, figures, captions, scores and artefacts -> results/report.html."""

from pathlib import Path

import pandas as pd

from vibrom.report import hard_cases, headline, page
from vibrom.report.captions import parse
from vibrom.report.scores import Scores
from vibrom.steps._files import collection, write


def run(
    *,
    scores: str,
    artefacts: list[str],
    tables: list[str],
    figures: list[str],
    captions: list[str],
    report: str,
    provenance: dict | None = None,
) -> None:
    runs, values = collection(artefacts), Scores(pd.read_csv(scores))
    numbers = {Path(path).stem: pd.read_csv(path) for path in tables if path.endswith(".csv")}
    pictures: dict[str, dict[str, bytes]] = {}
    for path in figures:
        if path.endswith((".svg", ".png")):
            pictures.setdefault(Path(path).stem, {})[Path(path).suffix.removeprefix(".")] = Path(
                path
            ).read_bytes()
    write(
        report,
        page.compose(
            collection=runs,
            headline=headline.sections(numbers),
            tables={
                Path(path).stem: Path(path).read_text(encoding="utf-8")
                for path in tables
                if path.endswith(".html")
            },
            figures=pictures,
            captions={
                f"{Path(path).parent.name}/{Path(path).stem}": parse(
                    Path(path).read_text(encoding="utf-8"), path
                )
                for path in captions
            },
            hard=hard_cases.table(runs, values, numbers.get("frc")),
            provenance=provenance or {},
        ),
    )
