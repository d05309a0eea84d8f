"""What a reduced-order model is: four functions, and how it is stored.

    z = encode(x),   x = decode(z),   dz/dt = drift(z) + force_map(z, p) u(t)

x (*batch, 2n) is displacement [m], then velocity [m/s], of the n free degrees of freedom; z
(*batch, 2d) are d reduced positions, then what goes with each as its velocity; the load is p u(t),
with p (n,) in N per unit of the signal u. Rollouts, response curves, backbones and timings are
functions of these four and of nothing else, so that every model answers the same questions in the
same way. Three more have defaults that a model may override where it can do better: `displacement`,
a part of `decode`; `field`, which is `drift` and `force_map` in compiled code; and `beside`, the
displacement that a load adds at once.
"""

from __future__ import annotations

import dataclasses
import importlib
import pkgutil
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import wraps
from typing import TYPE_CHECKING, Any, Literal, get_args

import numpy as np
import xarray as xr
from scipy.sparse import csr_matrix, issparse

from vibrom.artefacts.data import DataError
from vibrom.models.training import MethodError, Training, Unsupported

if TYPE_CHECKING:
    from vibrom.solvers.reduced.field import VectorField

HOMES = ("vibrom.latent", "vibrom.methods")  # the packages whose modules hold the classes of models

Extrapolation = Literal["none", "linear"]


def stored(units: str, long_name: str, *dims: str) -> Any:
    """A field of a Rom that is stored as a netCDF variable; a number where there are no `dims`."""
    return field(metadata={"units": units, "long_name": long_name, "dims": dims})


def stored_operator(units: str, long_name: str) -> Any:
    """A field of a Rom that is a sparse matrix, stored as its entries `<field>_row`, `_column` and
    `_value`.
    """
    return field(metadata={"units": units, "long_name": long_name})


def of_width(values: np.ndarray, width: int, name: str) -> np.ndarray:
    """`values` as an array, or a MethodError where its last axis has another length."""
    values = np.asarray(values)
    if values.ndim == 0 or values.shape[-1] != width:
        raise MethodError(f"{name} has the shape {values.shape}; its last axis must be {width}")
    return values


def _of_states(function: Callable[..., np.ndarray]) -> Callable[..., np.ndarray]:
    """The same function of z, which refuses a z of another width than the model's."""

    @wraps(function)
    def checked(self: Rom, z: np.ndarray, *given: Any, **named: Any) -> np.ndarray:
        return function(self, of_width(z, len(self.reach), "z"), *given, **named)

    return checked


@dataclass(frozen=True)
class Guards:
    """What keeps a fitted model from running away; see `latent.extrapolation` and
    `latent.dissipative`.
    """

    extrapolation: Extrapolation = "none"  # of polynomials beyond the training range
    # order of dynamics that are fitted again such that they cannot gain energy, and extrapolated
    # linearly; 0: as the method fits them
    dissipative: int = 0

    def __post_init__(self) -> None:
        if self.extrapolation not in get_args(Extrapolation):
            raise MethodError(f"extrapolation is {self.extrapolation!r}; give none or linear")
        if not (isinstance(self.dissipative, int) and self.dissipative >= 0):
            raise MethodError(
                f"dissipative is {self.dissipative!r}; give the order of the fit, or 0 for none"
            )


@dataclass(frozen=True)
class Rom(ABC):
    """A fitted model. Subclasses are frozen dataclasses whose fields are arrays (`stored`), sparse
    matrices (`stored_operator`), strings and numbers.
    """

    reach: np.ndarray = stored(  # (2d,), in the unit of each coordinate
        "1",
        "largest absolute reduced coordinate in the training data, in its own unit",
        "coordinate",
    )

    def __init_subclass__(cls) -> None:
        for name in ("decode", "drift", "force_map", "displacement"):
            if callable(function := vars(cls).get(name)):
                setattr(cls, name, _of_states(function))

    def __post_init__(self) -> None:
        reach = np.asarray(self.reach)
        if reach.ndim != 1 or len(reach) == 0 or len(reach) % 2 or not (reach > 0).all():
            raise MethodError(
                f"{type(self).__name__}.reach is {reach.tolist()}; give the largest of d reduced "
                "positions, then of their d velocities, all positive"
            )

    @abstractmethod
    def encode(self, x: np.ndarray) -> np.ndarray:
        """Reduced coordinates (*batch, 2d) of x (*batch, 2n)."""

    @abstractmethod
    def decode(self, z: np.ndarray) -> np.ndarray:
        """Displacement and velocity (*batch, 2n) of z (*batch, 2d)."""

    @abstractmethod
    def drift(self, z: np.ndarray) -> np.ndarray:
        """Rate dz/dt (*batch, 2d) where no load acts [1/s]."""

    @abstractmethod
    def force_map(self, z: np.ndarray, p: np.ndarray) -> np.ndarray:
        """What the load p (n,) [N] adds to dz/dt (*batch, 2d) [1/s]; Unsupported where the model
        does not know how loads act.
        """

    def displacement(self, z: np.ndarray, dofs: np.ndarray | None = None) -> np.ndarray:
        """The displacement (*batch, n) of z (*batch, 2d), or (*batch, k) at `dofs` [m]. Override if
        displacements can be computed without a full decode.
        """
        x = self.decode(z)
        q = x[..., : x.shape[-1] // 2]
        return q if dofs is None else q[..., dofs]

    def beside(
        self, z: np.ndarray, p: np.ndarray, dofs: np.ndarray | None = None
    ) -> np.ndarray | None:
        """What a load p u adds to the displacement of z without moving z, (2, *batch, n) or (2,
        *batch, k) at `dofs` [m]: per unit of the signal u, and of u a quarter of a period earlier;
        None: nothing is known of it.
        """
        return None

    def field(self, p: np.ndarray | None) -> VectorField | None:
        """`drift` and, under a load p, `force_map` in compiled code, for rollouts some hundred
        times faster; None: numpy is fast enough.

        A class that inherits a `field` and changes what it compiles overrides it too.
        """
        return None

    def guarded(self, guards: Guards, training: Training) -> Rom:
        """This model with these guards; `training` is what it was learnt from. Unsupported where
        the model has no such guard.
        """
        if guards == Guards():
            return self
        raise Unsupported(
            f"{type(self).__name__} has no guards; set extrapolation: none and dissipative: 0"
        )

    def to_dataset(self) -> xr.Dataset:
        """The model as `rom_from_dataset` reads it: a variable for each array, an attribute
        `rom_<field>` for each string or number, and the attribute `rom`, module:name of the class.
        """
        variables: dict[str, xr.Variable] = {}
        attributes = {"rom": f"{type(self).__module__}:{type(self).__qualname__}"}
        for item in dataclasses.fields(self):
            value, meta = getattr(self, item.name), dict(item.metadata)
            if value is None:
                continue
            if not meta:
                attributes[f"rom_{item.name}"] = value
            elif issparse(value):
                variables |= _entries(item.name, value.tocoo(), meta)
            else:
                variables[item.name] = xr.Variable(meta.pop("dims"), np.asarray(value), meta)
        return xr.Dataset(variables, attrs=attributes)


def _entries(name: str, matrix: Any, meta: dict[str, str]) -> dict[str, xr.Variable]:
    """Row, column and value of each entry of a sparse matrix."""
    parts = {"row": matrix.row, "column": matrix.col, "value": matrix.data}
    return {
        f"{name}_{part}": xr.Variable(
            ("entry",),
            values,
            {
                "units": meta["units"] if part == "value" else "1",
                "long_name": f"{part} of each entry of the {meta['long_name']}",
            },
        )
        for part, values in parts.items()
    }


def rom_from_dataset(dataset: xr.Dataset) -> Rom:
    """The model of a `rom.nc`, of the class that the dataset names.

    An outside tool writes the attribute `rom` (`vibrom.latent.polynomial_rom:PolynomialRom`, or
    another class of a model), one variable for each of the class's array fields, under the name of
    the field and with units and long_name, and an attribute `rom_<field>` for each string or number
    that differs from its default. A field that may be None may be left out. An artefact of the
    workflow also has the attributes `kind` (`rom`), `scene`, `method`, `seed` (-1: none) and
    `reason` (empty), and the variables `outcome` (`ok`), `data_seconds`, `mapping_seconds` and
    `dynamics_seconds`. With `asked`, the parameters of its rule, and `made_from`, the `content` of
    each input by its name, both as json, it is known to be stale where a results folder was copied.
    """
    cls, values, missing = _class(str(dataset.attrs.get("rom", ""))), {}, []
    for item in dataclasses.fields(cls):
        value = _value(dataset, item)
        if value is not None:
            values[item.name] = value
        elif item.metadata and "None" in str(item.type):
            values[item.name] = None
        elif item.default is dataclasses.MISSING:
            missing.append(item.name)
    if missing:
        raise DataError(
            f"the rom lacks {', '.join(missing)}, which {cls.__name__} needs; fit the model again, "
            "or let the outside tool write it"
        )
    return cls(**values)


def _value(dataset: xr.Dataset, item: dataclasses.Field) -> Any:
    """What the dataset holds of a field, or None."""
    if not item.metadata:
        value = dataset.attrs.get(f"rom_{item.name}")
        return value.item() if isinstance(value, np.generic) else value
    if "dims" in item.metadata:
        if item.name not in dataset:
            return None
        values = dataset[item.name].values
        return values if item.metadata["dims"] else values.item()
    if f"{item.name}_value" not in dataset:
        return None
    value, row, column = (
        dataset[f"{item.name}_{part}"].values for part in ("value", "row", "column")
    )
    size = int(max(row.max(), column.max())) + 1
    return csr_matrix((value, (row.astype(int), column.astype(int))), shape=(size, size))


def _class(named: str) -> type[Rom]:
    """The class of models of vibrom with this name, module:name; nothing else is imported."""
    module, _, name = named.partition(":")
    known = [
        f"{package}.{item.name}"
        for package in HOMES
        for item in pkgutil.iter_modules(importlib.import_module(package).__path__)
    ]
    if module in known:
        found = getattr(importlib.import_module(module), name, None)
        if isinstance(found, type) and issubclass(found, Rom) and found.__module__ == module:
            return found
    raise DataError(
        f"the attribute rom is {named!r}, which names no model class of vibrom; give one such as "
        "vibrom.latent.polynomial_rom:PolynomialRom, or fit the model again"
    )
