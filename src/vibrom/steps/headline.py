"""Tables -> the short table at the end of a run, on the screen and in a file."""

from pathlib import Path

import pandas as pd
from rich.console import Console

from vibrom.report import headline as numbers
from vibrom.steps._files import write


def run(
    *, scores: str, report: str, tables: list[str], headline: str, provenance: dict | None = None
) -> None:
    frames = {Path(path).stem: pd.read_csv(path) for path in tables if path.endswith(".csv")}
    places = {
        "Report": report,
        "Tables": str(Path(tables[0]).parent) if tables else "none",
        "Scores": scores,
        "MLflow": "make ui",
    }
    write(headline, numbers.text(frames, places))
    numbers.show(frames, places, Console())
