"""Artefact paths as a collection, and whole files out: what the reporting steps share.

results/{scene}/full_order/{name}.nc belongs to the full-order model,
results/{scene}/{method}/{seed}/{name}.nc to a reduced one.
"""

import os
from functools import partial
from pathlib import Path

import pandas as pd

from vibrom.artefacts.data import DataError, open_dataset
from vibrom.report.collection import FULL_ORDER, UNSEEDED, Collection
from vibrom.report.scores import COLUMNS, Scores

KIND = {"train": "trajectory", "test": "trajectory"}


def collection(artefacts: list[str]) -> Collection:
    """The datasets at these paths, opened when they are asked for."""
    loaders = {}
    for path in artefacts:
        *above, scene_or_method, model_or_seed, file = Path(path).parts
        name = Path(file).stem
        if model_or_seed == FULL_ORDER:
            key = (scene_or_method, FULL_ORDER, UNSEEDED, name)
        elif above:
            key = (above[-1], scene_or_method, model_or_seed, name)
        else:
            raise DataError(
                f"{path}: not an artefact of a run; give results/<scene>/<method>/<seed>/<name>.nc"
            )
        loaders[key] = partial(open_dataset, path, KIND.get(name, name))
    return Collection(loaders)


def scores_at(path: str | None) -> Scores:
    """The scores in this file; none where no reduced model took part."""
    return Scores(pd.read_csv(path) if path else pd.DataFrame(columns=list(COLUMNS)))


def write(path: str | Path, content: bytes | str) -> None:
    """All of the file, or leave it as it was."""
    target = Path(path)
    target.parent.mkdir(parents=True, exist_ok=True)
    partial_file = target.with_name(f".{target.name}.partial")
    try:
        partial_file.write_bytes(content.encode() if isinstance(content, str) else content)
        os.replace(partial_file, target)
    except OSError as error:
        cure = "free space or choose another results folder, then run again"
        raise DataError(f"{path}: cannot be written ({error}); {cure}") from error
    finally:
        partial_file.unlink(missing_ok=True)
