"""All benchmarks, or those named: results/benchmarks.csv and results/benchmarks.html.

    python -m benchmarks [name ...]

A named benchmark replaces its own rows and keeps the others'. Each is one file beside this one with
`measure(note)`, which yields rows, and perhaps `figures(rows)`.
"""

# ruff: noqa: E402
import os

# One core, unless a benchmark says otherwise; before numpy is imported.
for threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(threads, "1")

import importlib
import json
import sys
import time
from dataclasses import asdict
from pathlib import Path

import matplotlib
import pandas as pd
from rich.console import Console

from benchmarks import page
from vibrom.report.drawing.style import STYLE, render

# In the order of the page.
NAMES = (
    "full_order",
    "sweep",
    "effects",
    "growth",
    "memory",
    "elements",
    "solid",
    "budget",
    "compilation",
    "training",
    "rollouts",
    "equations",
    "branches",
    "workflow",
)
RESULTS = Path("results")


def main(chosen: list[str]) -> int:
    unknown = [name for name in chosen if name not in NAMES]
    if unknown:
        print(
            f"benchmark {unknown[0]!r} is unknown; choose from {', '.join(NAMES)}", file=sys.stderr
        )
        return 2
    console = Console(stderr=True)
    parts = RESULTS / "benchmarks" / "parts"
    parts.mkdir(parents=True, exist_ok=True)
    for name in chosen or NAMES:
        began = time.perf_counter()
        console.print(f"[bold]{name}[/bold]")
        module = importlib.import_module(f"benchmarks.{name}")
        rows = []
        for row in module.measure(lambda text: console.print(f"  [dim]{text}[/dim]")):
            rows.append(asdict(row) | {"ratio": row.ratio})
            against = (
                f"  ({row.rival}: {row.rival_value:.4g}, {row.ratio:.3g} times better)"
                if row.rival
                else ""
            )
            console.print(f"  {row.quantity}: {row.value:.4g} {row.unit}{against}", highlight=False)
        frame = pd.DataFrame(rows)
        with matplotlib.rc_context(STYLE):
            made = getattr(module, "figures", lambda rows: {})(frame) if len(frame) else {}
        figures = {figure: render(drawn, "svg").decode() for figure, drawn in made.items()}
        section = page.Section(
            name,
            *page.words(module.__doc__),
            rows,
            figures,
            time.perf_counter() - began,
            page.machine(),
        )
        (parts / f"{name}.json").write_text(json.dumps(asdict(section)))
    sections = [
        page.Section(**json.loads(path.read_text()))
        for path in (parts / f"{name}.json" for name in NAMES)
        if path.is_file()
    ]
    page.table(sections).to_csv(RESULTS / "benchmarks.csv", index=False)
    (RESULTS / "benchmarks.html").write_text(page.compose(sections), encoding="utf-8")
    print(
        f"Next: open {RESULTS / 'benchmarks.html'}; the numbers are in {RESULTS / 'benchmarks.csv'}"
    )
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
