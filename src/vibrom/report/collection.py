"""The datasets of a run, found by scene, model, seed and name, and opened only when a table or
figure asks for them.

A model is `full_order` or a method's name; a seed is the name of its folder: `seed_0`, `seed_1`,
... or `unseeded`.
"""

import json
from collections.abc import Callable, Mapping

import numpy as np
import xarray as xr

FULL_ORDER = "full_order"
UNSEEDED = "unseeded"

Key = tuple[str, str, str, str]  # scene, model, seed, name of the artefact


class Collection:
    def __init__(self, loaders: Mapping[Key, Callable[[], xr.Dataset]]):
        self.loaders = dict(loaders)

    @property
    def scenes(self) -> list[str]:
        return list(dict.fromkeys(key[0] for key in self.loaders))

    @property
    def methods(self) -> list[str]:
        """Reduced models, in the order of the run."""
        return [
            model for model in dict.fromkeys(key[1] for key in self.loaders) if model != FULL_ORDER
        ]

    def seeds(self, scene: str, method: str) -> list[str]:
        return list(dict.fromkeys(key[2] for key in self.loaders if key[:2] == (scene, method)))

    def find(self, scene: str, model: str, name: str, seed: str = UNSEEDED) -> xr.Dataset | None:
        """The dataset, or None where the run has none."""
        loader = self.loaders.get((scene, model, seed, name))
        return None if loader is None else loader()


def scalar(dataset: xr.Dataset | None, name: str, default=np.nan):
    """A scalar variable or attribute as a plain number or text."""
    if dataset is None:
        return default
    if name in dataset.variables:
        return dataset[name].values[()]
    return dataset.attrs.get(name, default)


def described(dataset: xr.Dataset, block: str) -> dict:
    """A block of the scene that a structure carries as an attribute: `body`, `effects`; empty where
    it does not.
    """
    return json.loads(dataset.attrs.get(block, "{}"))


def answered(dataset: xr.Dataset | None) -> bool:
    """Whether there are values; a model that could not be fitted leaves a dataset with an outcome
    and nothing else.
    """
    return dataset is not None and "nothing" not in dataset.dims


def probe_name(dataset: xr.Dataset) -> str:
    """The probe that is compared with the thesis: the one called `probe`, else the first."""
    names = [str(name) for name in dataset["probe"].values]
    return "probe" if "probe" in names else names[0]


def at_probe(dataset: xr.Dataset, name: str, probe: str | None = None) -> np.ndarray | None:
    """One variable at one probe (default: the thesis's); None where that probe does not exist."""
    if "probe" not in dataset.coords:
        return None
    probe = probe or probe_name(dataset)
    names = [str(known) for known in dataset["probe"].values]
    return dataset[name].values[names.index(probe)] if name in dataset and probe in names else None
