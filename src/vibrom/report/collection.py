"""The datasets of a run by scene, model, seed and name, each opened when it is needed.

Whose an artefact is, it says itself; one that lies where another belongs is refused.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import lru_cache, partial
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from vibrom.artefacts.data import open_dataset
from vibrom.artefacts.files import DataError
from vibrom.artefacts.identity import FITTED_ONCE, ROLES, attributes_of, place
from vibrom.artefacts.outcome import Outcome
from vibrom.config.places import FULL_ORDER

OPEN = 1024  # datasets that are kept in memory, but for their large variables,
LARGE = 2**17  # bytes: all that grows with the length of a motion is on disk until it is read


class Key(NamedTuple):
    """Whose an artefact is, and what."""

    scene: str
    model: str  # full_order, or a method
    seed: int | None  # None: of a model that is fitted once
    name: str  # the kind of the dataset; of a decay its role, train or test


class Collection:
    """The datasets of a run."""

    def __init__(self, loaders: Mapping[Key, Callable[[], xr.Dataset]]):
        self.loaders = dict(loaders)
        self._open = lru_cache(OPEN)(lambda key: self.loaders[key]())

    @classmethod
    def at(cls, paths: Iterable[str]) -> Collection:
        """The artefacts at these paths, in their order."""
        loaders = {}
        for path in paths:
            # Where it lies says whose it is, and opening it checks that.
            attributes = place(path) or artefact_at(path)
            seed = int(attributes["seed"])
            name = attributes.get("role", attributes.get("kind"))
            kind = "trajectory" if name in ROLES else name
            model = None if seed == FITTED_ONCE else seed
            key = Key(attributes["scene"], attributes["method"], model, name)
            loaders[key] = partial(open_dataset, path, kind, lazy=True, large=LARGE)
        return cls(loaders)

    @property
    def scenes(self) -> list[str]:
        """In the order of the run."""
        return list(dict.fromkeys(key.scene for key in self.loaders))

    @property
    def methods(self) -> list[str]:
        """Reduced models, in the order of the run."""
        models = dict.fromkeys(key.model for key in self.loaders)
        return [model for model in models if model != FULL_ORDER]

    @property
    def models(self) -> list[tuple[str, str]]:
        """Each scene with the full order, then with each method."""
        return [(scene, model) for scene in self.scenes for model in (FULL_ORDER, *self.methods)]

    def seeds(self, scene: str, model: str) -> list[int | None]:
        """Those of a model in a scene; one None where it is fitted once."""
        return list(dict.fromkeys(key.seed for key in self.loaders if key[:2] == (scene, model)))

    def find(self, scene: str, model: str, name: str, seed: int | None = None) -> xr.Dataset | None:
        """The dataset, or None where the run has none."""
        key = Key(scene, model, seed, name)
        return self._open(key) if key in self.loaders else None

    def has(self, address: str) -> bool:
        """Is there an artefact at <scene>/full_order/<name>.nc?"""
        scene, model, name = address.removesuffix(".nc").split("/")
        return Key(scene, model, None, name) in self.loaders

    def mesh(self, scene: str) -> xr.Dataset | None:
        """The structure of a scene with a body that can be drawn; None of a recorded one."""
        known = self.find(scene, FULL_ORDER, "structure")
        return known if known is not None and "node" in known else None

    def every(self, scene: str, model: str, name: str) -> list[xr.Dataset | None]:
        """The dataset of each seed."""
        return [self.find(scene, model, name, seed) for seed in self.seeds(scene, model)]


def artefact_at(path: str) -> dict[str, Any]:
    """The attributes of the artefact at a path that does not say whose it is."""
    found = attributes_of(path)
    missing = [name for name in ("scene", "method", "seed", "kind") if name not in found]
    if missing:
        raise DataError(
            f"{path}: not an artefact of a run, as it has no attribute {', '.join(missing)}; "
            "give files that the workflow made"
        )
    return found


def scalar(dataset: xr.Dataset | None, name: str, default: Any = np.nan) -> Any:
    """A scalar variable or attribute as a plain number or text."""
    if dataset is None:
        return default
    if name in dataset.variables:
        return dataset[name].values[()]
    return dataset.attrs.get(name, default)


def outcome(dataset: xr.Dataset | None) -> Outcome:
    """How a run or a fit ended; one that says nothing ended well."""
    absent = Outcome.NOT_RUN if dataset is None else Outcome.OK
    return Outcome(str(scalar(dataset, "outcome", absent)))


def described(dataset: xr.Dataset | None, block: str) -> dict:
    """A block of the scene that an artefact carries as an attribute: `body`, `effects`; empty where
    it does not.
    """
    return {} if dataset is None else json.loads(dataset.attrs.get(block, "{}"))


def answered(dataset: xr.Dataset | None) -> bool:
    """Are there values? A model that could not be fitted leaves an outcome and nothing else."""
    return dataset is not None and bool(dataset.attrs.get("answered", True))


def by_method(study: xr.Dataset) -> Iterator[tuple[str, xr.Dataset]]:
    """Each method of a study, and what the study knows of its fits."""
    for method in dict.fromkeys(study["model"].values.tolist()):
        yield method, study.isel(fit=study["model"].values == method)


def probe_name(dataset: xr.Dataset) -> str:
    """The probe that is compared with the thesis: the one called `probe`, else the first."""
    names = [str(name) for name in dataset["probe"].values]
    return "probe" if "probe" in names else names[0]


def at_probe(dataset: xr.Dataset, name: str, probe: str | None = None) -> np.ndarray | None:
    """One variable at one probe (default: the thesis's); None where that does not exist."""
    if "probe" not in dataset.coords or name not in dataset:
        return None
    probe = probe or probe_name(dataset)
    if probe not in dataset["probe"].values:
        return None
    return dataset[name].sel(probe=probe).values


def probe_dof(structure: xr.Dataset, probe: str) -> int | None:
    """The free displacement of a probe; None where the scene has no such probe."""
    dof = at_probe(structure, "probe_dof", probe)
    return None if dof is None else int(dof)
