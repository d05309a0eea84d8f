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
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr
from scipy.sparse import csr_matrix

from vibrom.artefacts.data import DataError

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
        raise MethodError(
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


@dataclass(frozen=True)
class Trajectory:
    """One decaying motion: time (m,) [s]; displacement, velocity, acceleration (m, n) [m, m/s,
    m/s^2].
    """

    time: np.ndarray
    displacement: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray

    @property
    def state(self) -> np.ndarray:
        """X (m, 2n)."""
        return np.concatenate([self.displacement, self.velocity], axis=-1)

    @property
    def rate(self) -> np.ndarray:
        """dx/dt (m, 2n)."""
        return np.concatenate([self.velocity, self.acceleration], axis=-1)


@dataclass(frozen=True)
class Structure:
    """What the scene knows: M [kg], C [kg/s], K [N/m]; mass-normalised modes (k, n) and their
    frequencies (k,) [rad/s].
    """

    mass: csr_matrix
    damping: csr_matrix
    stiffness: csr_matrix
    modes: np.ndarray
    frequencies: np.ndarray

    def leading(self, count: int, setting: str = "modes") -> np.ndarray:
        """The first `count` modes (count, n); a MethodError names the setting that asks for more
        than there are.
        """
        if not 1 <= count <= len(self.modes):
            raise MethodError(
                f"{setting} = {count}: the structure holds {len(self.modes)} modes; choose 1 to {len(self.modes)}"
            )
        return self.modes[:count]


class Monitor:
    """What a fit tells while it runs; this one listens to nothing. Steps give one that shows
    progress and keeps checkpoints.
    """

    @contextmanager
    def phase(self, name: str) -> Iterator[None]:
        """Marks the time spent on the `mapping` or on the `dynamics`."""
        yield

    def epoch(self, epoch: int, epochs: int, losses: dict[str, float]) -> None:
        """One row of the loss history."""

    def restore(self) -> dict[str, Any] | None:
        """The last state given to `checkpoint`, if a fit was interrupted."""
        return None

    def checkpoint(self, state: dict[str, Any]) -> None:
        """Keep `state` (arrays, numbers, strings) in case the fit is interrupted."""


@dataclass(frozen=True)
class Training:
    """All that a method may learn from. `structure` is None for data without operators."""

    trajectories: tuple[Trajectory, ...]
    test: tuple[Trajectory, ...] = ()
    structure: Structure | None = None
    seed: int | None = None
    device: str = "cpu"
    start: Rom | None = None
    monitor: Monitor = field(default_factory=Monitor)

    def joined(self, what: str) -> np.ndarray:
        """`displacement`, `velocity`, `acceleration`, `state` or `rate` of all trajectories, one
        after the other.
        """
        return np.concatenate([getattr(item, what) for item in self.trajectories])

    def require_structure(self, method: str) -> Structure:
        if self.structure is None:
            raise MethodError(
                f"{method} needs mass, damping, stiffness and modes, and this training set has none; use a method that does not"
            )
        return self.structure


class MethodError(ValueError):
    """A method that cannot be fitted to what it was given; the message names the cure."""


class TrainingDiverged(RuntimeError):
    """The loss became non-finite; says at which epoch."""


@dataclass(frozen=True)
class Method(ABC):
    """How to learn a Rom. The fields are the settings of its config block; those of `Guards` are
    every method's.
    """

    extrapolation: str = field(default="none", kw_only=True)
    dissipative: int = field(default=0, kw_only=True)

    @abstractmethod
    def fit(self, training: Training) -> Rom: ...

    def learn(self, training: Training) -> Rom:
        """`fit`, then the guards."""
        guards, fitted = Guards(self.extrapolation, self.dissipative), self.fit(training)
        with training.monitor.phase("dynamics"):
            return fitted.guarded(guards, training)

    def skip(self, scene: dict[str, Any]) -> str | None:
        """Why this method is not asked in a scene with these `body` and `effects` blocks, or None."""
        return None


def method_from_settings(name: str, settings: dict[str, Any]) -> Method:
    """The one Method of `vibrom.methods.<name>`, with these settings."""
    module = importlib.import_module(f"vibrom.methods.{name}")
    found = [
        item
        for item in vars(module).values()
        if isinstance(item, type)
        and issubclass(item, Method)
        and item.__module__ == module.__name__
    ]
    if len(found) != 1:
        raise MethodError(
            f"methods/{name}.py defines {len(found)} methods; define exactly one subclass of Method"
        )
    known = {item.name for item in dataclasses.fields(found[0])}
    if unknown := sorted(set(settings) - known):
        raise MethodError(
            f"methods.{name}.{unknown[0]} = {settings[unknown[0]]!r} is unknown; known settings: {', '.join(sorted(known))}"
        )
    return found[0](**settings)
