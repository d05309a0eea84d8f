"""All files of a run -> ro-crate-metadata.json: what was made from what, by which code."""

import json
from pathlib import Path

from vibrom.artefacts.files import write
from vibrom.report.crate import metadata


def run(*, artefacts: list[str], shown: list[str], crate: str, provenance: dict[str, str]) -> None:
    """`shown` are tables, figures and pages."""
    made = metadata(Path(crate).parent, artefacts, shown, provenance)
    write(crate, json.dumps(made, indent=1) + "\n")
