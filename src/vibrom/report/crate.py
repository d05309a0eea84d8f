"""Where every file of a run comes from, as an RO-Crate after the profile Process Run Crate 0.5.

Each artefact is the result of an action. Its objects are the artefacts that it was made from, known
by the digests of their content, and the settings that were asked for; its instrument is this
package, with the versions of what it computed with. Tables, figures and pages are the results of
one more action. The files stay where they are, beside their description.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from rocrate.model.contextentity import ContextEntity
from rocrate.model.file import File
from rocrate.rocrate import ROCrate

from vibrom.artefacts.identity import attributes_of

PROFILE = "https://w3id.org/ro/wfrun/process/0.5"
FORMATS = {
    ".nc": "application/x-netcdf",
    ".csv": "text/csv",
    ".html": "text/html",
    ".svg": "image/svg+xml",
    ".pdf": "application/pdf",
    ".png": "image/png",
    ".tex": "application/x-tex",
}


def metadata(
    folder: Path, artefacts: Iterable[str], shown: Iterable[str], provenance: dict[str, str]
) -> dict[str, Any]:
    """The description, as it stands in `ro-crate-metadata.json`; `artefacts` and what is `shown` of
    them are paths below `folder`.
    """
    crate = ROCrate(gen_preview=False)
    crate.name = "Runs of vibrom"
    crate.description = (
        "Full-order simulations of a structure, reduced-order models of it, and how well they "
        "predict, as netCDF files; with tables, figures and a report made from them."
    )
    profile = named(crate, PROFILE, "CreativeWork", name="Process Run Crate", version="0.5")
    crate.root_dataset.append_to("conformsTo", profile)
    terms = "Belongs to those who ran it; vibrom itself is under the MIT license."
    crate.license = named(crate, "#license", "CreativeWork", name="All rights", description=terms)
    versions = {}
    made = {path: attributes_of(path) for path in artefacts}
    for attributes in made.values():
        versions |= json.loads(attributes.get("versions", "{}"))
    versions |= json.loads(provenance["versions"])
    package = named(
        crate,
        "#vibrom",
        "SoftwareApplication",
        name="vibrom",
        softwareVersion=versions.get("vibrom", "unknown"),
        softwareRequirements=[f"{name} {value}" for name, value in sorted(versions.items())],
    )
    files = {path: described(crate, folder, path, made[path].get("title")) for path in made}
    by_content = {made[path].get("content"): file for path, file in files.items()}
    for path, file in files.items():
        read = json.loads(made[path].get("made_from", "{}")).values()
        digests = [item for one in read for item in (one if isinstance(one, list) else [one])]
        known = [by_content[digest] for digest in dict.fromkeys(digests) if digest in by_content]
        about = named(
            crate,
            f"#settings/{file.id}",
            "PropertyValue",
            name="asked",
            value=made[path].get("asked", "{}"),
        )
        act(crate, package, path, [*known, about], [file])
    pages = [described(crate, folder, path) for path in shown]
    if pages:
        act(crate, package, max(shown, key=modified), list(files.values()), pages)
    crate.datePublished = max(map(modified, [*made, *shown]))
    return crate.metadata.generate()


def named(crate: ROCrate, identity: str, kind: str, **properties: Any) -> ContextEntity:
    """Something that is no file."""
    return crate.add(ContextEntity(crate, identity, properties={"@type": kind, **properties}))


def described(crate: ROCrate, folder: Path, path: str, title: str | None = None) -> File:
    """A file where it lies, with the sum that tells whether it is still the same."""
    content, below = Path(path).read_bytes(), Path(path).relative_to(folder)
    about = {
        "name": title or below.name,
        "encodingFormat": FORMATS.get(below.suffix, "application/octet-stream"),
        "contentSize": str(len(content)),
        "sha256": hashlib.sha256(content).hexdigest(),
    }
    return crate.add_file(path, str(below), properties=about)


def act(crate: ROCrate, package: ContextEntity, path: str, objects: list, results: list) -> None:
    """What made these results of these objects, and when it was done."""
    name = f"vibrom made {results[0].id}" + (f" and {len(results) - 1} more" * (len(results) > 1))
    action = named(
        crate, f"#made/{results[0].id}", "CreateAction", name=name, endTime=modified(path)
    )
    for key, values in (("instrument", [package]), ("object", objects), ("result", results)):
        for value in values:
            action.append_to(key, value)
    crate.root_dataset.append_to("mentions", action)


def modified(path: str) -> str:
    """When a file was written."""
    return datetime.fromtimestamp(Path(path).stat().st_mtime, UTC).isoformat(timespec="seconds")
