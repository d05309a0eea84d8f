"""Artefacts and, where reduced models took part, scores.csv -> results/figures/<name>.svg, .pdf and
.png.
"""

from pathlib import Path

from vibrom.report import names
from vibrom.report.figures import draw
from vibrom.report.figures.style import render
from vibrom.steps._files import collection, scores_at, write


def run(
    *,
    artefacts: list[str],
    figures: list[str],
    scores: str | None = None,
    provenance: dict | None = None,
) -> None:
    runs, values = collection(artefacts), scores_at(scores)
    digest = (provenance or {}).get("source_digest", "unknown")
    for name in dict.fromkeys(Path(path).stem for path in figures):
        figure = draw(name, runs, values)
        for path in (path for path in figures if Path(path).stem == name):
            form = Path(path).suffix.removeprefix(".")
            if form not in names.FIGURE_FORMATS:
                raise ValueError(
                    f"{path}: a figure is written as .{', .'.join(names.FIGURE_FORMATS)}; rename the output"
                )
            write(path, render(figure, form, digest))
