"""The benchmark page: one HTML file, each number with the command that makes it."""

import platform
from dataclasses import dataclass
from pathlib import Path

import numba
import pandas as pd
import torch
from jinja2 import Environment
from markupsafe import Markup

from vibrom.artefacts.hardware import description
from vibrom.artefacts.provenance import versions
from vibrom.report.page import image, resource

COLUMNS = ["benchmark", "quantity", "value", "unit", "rival", "rival_value", "ratio"]


@dataclass(frozen=True)
class Section:
    """What one benchmark found."""

    name: str
    title: str
    paragraphs: list[str]
    rows: list[dict]
    figures: dict[str, str]  # name -> SVG
    seconds: float  # that it took
    machine: dict[str, str]


def words(docstring: str) -> tuple[str, list[str]]:
    """Title and paragraphs of a docstring."""
    title, *paragraphs = docstring.strip().split("\n\n")
    return title.rstrip("."), [" ".join(paragraph.split()) for paragraph in paragraphs]


def machine() -> dict[str, str]:
    known = description()
    return {
        "processor": known["processor"],
        "cores": str(known["cores"]),
        "load when it ended": str(known["load"]),
        "instruction set": torch.backends.cpu.get_cpu_capability(),
        "compiler": f"numba {numba.__version__}",
        "python": platform.python_version(),
    }


def table(sections: list[Section]) -> pd.DataFrame:
    return pd.DataFrame([row for section in sections for row in section.rows], columns=COLUMNS)


def compose(sections: list[Section]) -> str:
    def shown(frame: pd.DataFrame) -> Markup:
        def number(value: float) -> str:
            return "" if pd.isna(value) else f"{value:.4g}"

        cells = {
            "quantity": frame["quantity"],
            "value": frame["value"].map(number),
            "unit": frame["unit"],
            "rival": frame["rival"],
            "rival's value": frame["rival_value"].map(number),
            "times better": frame["ratio"].map(
                lambda value: "" if pd.isna(value) else f"{value:.3g}"
            ),
        }
        kept = pd.DataFrame({key: column for key, column in cells.items() if (column != "").any()})
        return Markup(kept.to_html(index=False, border=0, classes="data", justify="left"))

    environment = Environment(autoescape=True, trim_blocks=True, lstrip_blocks=True)
    template = Path(__file__).with_name("page.html.j2").read_text(encoding="utf-8")
    return environment.from_string(template).render(
        css=Markup(resource("page.css")),
        versions=versions(["numpy", "scipy", "skfem", "numba", "torch"]),
        sections=[
            {
                "name": section.name,
                "title": section.title,
                "paragraphs": section.paragraphs,
                "seconds": round(section.seconds),
                "machine": section.machine,
                "table": shown(pd.DataFrame(section.rows)) if section.rows else None,
                "figures": {
                    name: image({"svg": drawn.encode()}) for name, drawn in section.figures.items()
                },
            }
            for section in sections
        ],
    )
