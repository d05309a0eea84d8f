"""What was measured, in place of the full order: it has a linear part, and moves no more."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NoReturn

import numpy as np
import xarray as xr

from vibrom.models.model import Drive, Motion, Signals, Watch
from vibrom.models.recorded import damped_frequency
from vibrom.models.training import Unsupported
from vibrom.solvers.periodic.maps import ReturnMap


@dataclass(frozen=True)
class Measured:
    """See `Model`."""

    size: int  # n, displacements
    probes: np.ndarray  # (k,) displacement that each probe watches
    frequency: float  # rad/s, damped first frequency
    poles: np.ndarray  # (2k,) of the linear part, 1/s
    samples: int = 200

    @classmethod
    def of_scene(cls, known: xr.Dataset) -> Measured:
        """What the scene's structure says."""
        omega, zeta = known["frequency"].values, known["damping_ratio"].values
        root = np.sqrt(np.asarray(zeta, complex) ** 2 - 1.0)
        poles = np.concatenate([omega * (-zeta + root), omega * (-zeta - root)])
        probes = known["probe_dof"].values
        return cls(known.sizes["dof"], probes, damped_frequency(known), poles)

    def eigenvalues(self) -> np.ndarray:
        """See `Model.eigenvalues`."""
        return self.poles

    def motion(self, start: np.ndarray, drive: Drive | Signals | None, *watches: Watch) -> Motion:
        """Unsupported."""
        self._refuse()

    def coordinates(self, state: np.ndarray) -> np.ndarray:
        """Unsupported."""
        self._refuse()

    def decoded(self, coordinates: np.ndarray, dofs: np.ndarray | None = None) -> np.ndarray:
        """Unsupported."""
        self._refuse()

    def return_map(self) -> ReturnMap:
        """Unsupported."""
        self._refuse()

    def _refuse(self) -> NoReturn:
        raise Unsupported("this scene is a recording, and no more of it was measured")
