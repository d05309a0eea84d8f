"""What a study reads -> its artefact of a scene, of a fitted model, or of all fitted models."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

from vibrom import studies
from vibrom.artefacts.data import label, open_dataset, save_dataset
from vibrom.artefacts.hardware import description
from vibrom.studies import Case, Fitted

KINDS = {"train": "trajectory", "test": "trajectory"}
FULL_ORDER = "full_order/"


def run(
    *,
    output: str,
    study: dict[str, Any],
    names: dict[str, Any],
    case: dict[str, Any],
    structure: str,
    provenance: dict[str, str],
    full_order: Sequence[str] = (),
    fitted: Sequence[str] = (),
) -> None:
    """`study` has its name, settings and the kind of job; `names` are scene, method and seed of the
    artefact; `case` holds what a `Case` holds besides datasets. `full_order` are the paths of what
    the job reads of the full order, and `fitted` those of each model: its fit, then its answers,
    both in the order of the study's `reads`.
    """
    name, kind, settings = study["name"], study["kind"], study["settings"]
    made = studies.study(name, settings)
    reads = made.reads.get(kind, ())
    of_scene = [need.removeprefix(FULL_ORDER) for need in reads if need.startswith(FULL_ORDER)]
    own = [need for need in reads if not need.startswith(FULL_ORDER)]
    each = 1 + len(own)
    models = [fitted[first : first + each] for first in range(0, len(fitted), each)]
    dataset = made.job(
        kind,
        Case(
            structure=open_dataset(structure, "structure"),
            full_order=opened(of_scene, full_order),
            fitted=tuple(
                Fitted(open_dataset(rom, "rom"), opened(own, answers)) for rom, *answers in models
            ),
            **case,
        ),
    )
    dataset = label(
        dataset,
        made.jobs[kind],
        **names,
        study=name,
        settings=json.dumps(settings, sort_keys=True),
        hardware=description(),
    )
    save_dataset(dataset, output, provenance)


def opened(names: Sequence[str], paths: Sequence[str]) -> dict[str, Any]:
    """The artefacts of these names."""
    return {
        name: open_dataset(path, KINDS.get(name, name), lazy=True)
        for name, path in zip(names, paths, strict=True)
    }
