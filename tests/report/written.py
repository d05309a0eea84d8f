"""What the last steps write of the small run: tables, figures, page, store, headline."""

from pathlib import Path

from small_run import PROVENANCE

from vibrom.report import outputs
from vibrom.steps import headline, output, report, scores, tracking

SCENES, EXPERIMENTS = ["small", "large"], ["decay", "backbone"]
TABLES = outputs.tables("models", EXPERIMENTS)
FIGURES = outputs.figures("models", SCENES)
PLUGS = {drawing.plug for drawing in FIGURES.values()}


def write(small, folder: Path) -> None:
    """Into this folder; the page twice."""
    common = {"artefacts": small.paths, "provenance": PROVENANCE}
    known = {"scores": str(folder / "scores.csv")}
    scored = {*small.settings.experiments, "train", "test", "trust"}
    predictions = [path for path in small.paths if Path(path).stem in scored]
    scores.run(predictions=predictions, provenance=PROVENANCE, **known)
    written = [str(folder / "tables" / f"{name}.csv") for name in TABLES]
    output.run(kind="tables", outputs=written, **known, **common)
    pictures = [str(folder / "figures" / f"{name}.svg") for name in FIGURES]
    output.run(kind="figures", outputs=pictures[:2], **common)
    for path in pictures[2:]:  # what is in a picture is tested elsewhere
        Path(path).write_text("<svg/>")
    captions = outputs.captions({"tables": TABLES, "figures": list(PLUGS)})
    for name in ("report.html", "again.html"):
        report.run(
            report=str(folder / name),
            figures=pictures,
            tables_shown=TABLES,
            captions={key: [*caption] for key, caption in captions.items()},
            **known,
            **common,
        )
    store, artifacts = str(folder / "mlflow.db"), str(folder / "artifacts")
    kept = {"tables": written, "figures": pictures[:1]}
    tracking.run(store=store, artifacts=artifacts, **known, **kept, **common)
    end = {"report": str(folder / "report.html"), "headline": str(folder / "headline.txt")}
    crate = str(folder / "ro-crate-metadata.json")
    headline.run(store=store, crate=crate, **known, **end, **common)
