"""What a reduced-order model is: four functions, and how it is learnt and stored.

    z = encode(x),   x = decode(z),   dz/dt = drift(z) + force_map(z, p) u(t)

x (*batch, 2n) is displacement [m], then velocity [m/s], of the n free degrees of freedom; z
(*batch, 2d) are d reduced positions, then what goes with each as its velocity; `reach` (2d,) holds
the largest of each in the training data, and their ratio is a time scale of the model; the load is
p u(t), with p (n,) in N per unit of the signal u. Rollouts, response curves, backbones and timings
are functions of these four and nothing else, so that every model answers the same questions in the
same way. A model may say the same a quicker way: `displacement` is a part of `decode`, and `field`
is `drift` and `force_map` in compiled code.
"""

from __future__ import annotations

import dataclasses
import importlib
from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from vibrom.artefacts.data import DataError
from vibrom.models.training import MethodError, Training, Unsupported

if TYPE_CHECKING:
    from vibrom.solvers.reduced.field import Field


def array_field(units: str, long_name: str, dims: tuple[str, ...]) -> Any:
    """A field of a Rom that is stored as a netCDF variable."""
    return field(metadata={"units": units, "long_name": long_name, "dims": dims})


@dataclass(frozen=True)
class Guards:
    """What keeps a fitted model from running away; see `latent.extrapolation` and
    `latent.dissipative`.
    """

    # of polynomials, of dynamics and decoder, beyond the training range: none, or linear
    extrapolation: str = "none"
    # order of dynamics fitted anew so that they cannot gain energy, which is linear extrapolation
    # too; 0: as the method fits them
    dissipative: int = 0

    def __post_init__(self) -> None:
        if self.extrapolation not in ("none", "linear"):
            raise MethodError(f"extrapolation is {self.extrapolation!r}; give none or linear")
        if not (isinstance(self.dissipative, int) and self.dissipative >= 0):
            raise MethodError(
                f"dissipative is {self.dissipative!r}; give the order of the fit, or 0 for none"
            )


@dataclass(frozen=True)
class Rom(ABC):
    """A fitted model. Subclasses are frozen dataclasses of arrays (`array_field`), strings and
    numbers.
    """

    reach: np.ndarray = array_field(
        "1",
        "largest absolute reduced coordinate in the training data, in its own unit",
        ("coordinate",),
    )

    def __post_init__(self) -> None:
        reach = np.asarray(self.reach)
        if reach.ndim != 1 or len(reach) == 0 or len(reach) % 2 or not (reach > 0).all():
            raise MethodError(
                f"{type(self).__name__}.reach is {reach.tolist()}; give the largest of d reduced positions, then of their d velocities, all positive"
            )

    @abstractmethod
    def encode(self, x: np.ndarray) -> np.ndarray: ...

    @abstractmethod
    def decode(self, z: np.ndarray) -> np.ndarray: ...

    @abstractmethod
    def drift(self, z: np.ndarray) -> np.ndarray: ...

    @abstractmethod
    def force_map(self, z: np.ndarray, p: np.ndarray) -> np.ndarray: ...

    def displacement(self, z: np.ndarray, dofs: np.ndarray | None = None) -> np.ndarray:
        """The displacement (*batch, n) that `decode` gives, or (*batch, k) at `dofs`; a model may
        know a shorter way than to decode everything.
        """
        x = self.decode(z)
        q = x[..., : x.shape[-1] // 2]
        return q if dofs is None else q[..., dofs]

    def field(self, p: np.ndarray | None) -> Field | None:
        """`drift` and, under a load p, `force_map` in compiled code, for rollouts some hundred
        times quicker; None: numpy will do.

        A class that inherits a `field` and changes what it compiles changes it too, or answers
        None.
        """
        return None

    def guarded(self, guards: Guards, training: Training) -> Rom:
        """This model with these guards; `training` is what it was learnt from."""
        if guards == Guards():
            return self
        raise Unsupported(
            f"{type(self).__name__} has no guards; set extrapolation: none and dissipative: 0"
        )

    def to_dataset(self) -> xr.Dataset:
        variables, attributes = {}, {"rom": f"{type(self).__module__}:{type(self).__qualname__}"}
        for item in dataclasses.fields(self):
            value = getattr(self, item.name)
            if value is None:
                continue
            if "dims" in item.metadata:
                meta = {key: item.metadata[key] for key in ("units", "long_name")}
                variables[item.name] = xr.Variable(item.metadata["dims"], np.asarray(value), meta)
            else:
                attributes[f"rom_{item.name}"] = value
        return xr.Dataset(variables, attrs=attributes)


def rom_from_dataset(dataset: xr.Dataset) -> Rom:
    """The model that `Rom.to_dataset` stored, of the class that the dataset names."""
    module, _, name = str(dataset.attrs.get("rom", "")).partition(":")
    if not module.startswith("vibrom."):
        raise DataError(
            f"rom attribute is {module!r}: it names no model class of vibrom; fit the model again"
        )
    cls = getattr(importlib.import_module(module), name)
    values: dict[str, Any] = {}
    for item in dataclasses.fields(cls):
        if "dims" in item.metadata:
            values[item.name] = dataset[item.name].values if item.name in dataset else None
        elif f"rom_{item.name}" in dataset.attrs:
            value = dataset.attrs[f"rom_{item.name}"]
            values[item.name] = value.item() if isinstance(value, np.generic) else value
    return cls(**values)
