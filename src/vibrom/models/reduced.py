"""A fitted reduced-order model in a scene: it answers what the full-order model answers."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from vibrom.models.calibration import Calibration, Signalled, calibration
from vibrom.models.decoded import Driven, decoded
from vibrom.models.model import Drive, Motion, Push, Signals, Watch
from vibrom.models.recorded import damped_frequency
from vibrom.models.rollout import Drive as LoadedDrive
from vibrom.models.rollout import Integrator, decode_displacement, pushed, rollout
from vibrom.models.rom import Rom
from vibrom.models.training import Unsupported

if TYPE_CHECKING:
    from vibrom.solvers.periodic.flow_map import FlowMap

AT_A_TIME = 2**22  # displacements that are decoded
CLOSE = 1e-9  # of a run: instants that are one
JACOBIAN_STEP = 1e-5  # of the training range: differences of a cubic drift are exact to about 1e-10


@dataclass(frozen=True)
class Reduced:
    """A Rom, the scene's load and probes, and how its motion is integrated."""

    rom: Rom
    load: np.ndarray  # (n,) N per unit of the signal; NaN: not known
    probes: np.ndarray  # (k,) free displacement that each probe watches
    frequency: float  # rad/s, damped first frequency of the scene
    integrator: Integrator
    # Of a period: a maximum between two instants is missed by at most (pi/500)^2/2 = 2e-5 of it.
    samples: int = 500
    calibration: Calibration | Signalled | None = None  # of the load's strength; None: it is known

    @classmethod
    def of_scene(cls, rom: Rom, known: xr.Dataset, integrator: Integrator) -> Reduced:
        """A fitted model in the scene of this structure."""
        load, probes = known["load"].values, known["probe_dof"].values
        first, strength = damped_frequency(known), calibration(known)
        return cls(rom, load, probes, first, integrator, calibration=strength)

    @cached_property
    def known_load(self) -> np.ndarray:
        """The load, calibrated where its strength is not known; Unsupported where nothing is."""
        return self.load * self.strength

    @cached_property
    def strength(self) -> float:
        """Of the load, calibrated where it is not known; Unsupported where nothing is."""
        if np.isnan(self.load).any():
            raise Unsupported("the load of this scene is not known; say what drives it (`forcing`)")
        if self.calibration is None:
            return 1.0
        return self.calibration.strength(self.rom, self.load)

    @property
    def size(self) -> int:
        """n, free displacements."""
        return len(self.load)

    def coordinates(self, state: np.ndarray) -> np.ndarray:
        """Reduced coordinates (m, r) of `state` (m, 2n)."""
        return self.rom.encode(state)

    def eigenvalues(self) -> np.ndarray:
        """Of d drift / dz at rest [1/s]."""
        steps = np.diag(JACOBIAN_STEP * self.rom.reach)
        difference = self.rom.drift(steps) - self.rom.drift(-steps)
        return np.linalg.eigvals(difference.T / (2.0 * JACOBIAN_STEP * self.rom.reach))

    def motion(self, start: np.ndarray, drive: Push, *watches: Watch) -> Motion:
        """See `Model.motion`."""
        if isinstance(drive, Signals):
            return self._pushed(start, drive, *watches)
        runs, encoded = len(start), self.rom.encode(start)
        forcing = None
        if drive is not None:
            forcing = LoadedDrive(self.known_load, drive.amplitude, drive.frequency)
        every = [
            np.broadcast_to(watch.instants, (runs, np.shape(watch.instants)[-1]))
            for watch in watches
        ]
        instants = np.concatenate(every, axis=1)
        order = np.argsort(instants, axis=1, kind="stable")
        began = time.perf_counter()
        run = rollout(
            self.rom, encoded, np.take_along_axis(instants, order, axis=1), self.integrator, forcing
        )
        reduced = np.empty_like(run.reduced)
        np.put_along_axis(reduced, order[:, :, None], run.reduced, axis=1)
        seconds = time.perf_counter() - began
        ends = np.cumsum([part.shape[1] for part in every])[:-1]
        parts = tuple(np.split(reduced, ends, axis=1))
        shown = [
            self._shapes(part, moments, drive, watch.dofs)
            for part, moments, watch in zip(parts, every, watches)
        ]
        return _motion(run, parts, shown, seconds)

    def _pushed(self, start: np.ndarray, signals: Signals, *watches: Watch) -> Motion:
        """Under signals of any kind. Of what a load adds beside the reduced coordinates, the part
        that is in phase with it.
        """
        signals, began = replace(signals, load=self.strength * signals.load), time.perf_counter()
        watched = np.unique(np.concatenate([[0.0], *(watch.instants for watch in watches)]))
        # Near instants of several watches are one.
        watched = watched[np.diff(watched, prepend=-1.0) > CLOSE * watched[-1]]
        longest = 2.0 * np.pi / self.frequency / self.samples
        parts = np.maximum(np.ceil(np.diff(watched) / longest - CLOSE), 1.0).astype(int)
        first = np.repeat(watched[:-1], parts)
        within = np.concatenate([np.arange(count) / count for count in parts])
        grid = np.append(first + within * np.repeat(np.diff(watched), parts), watched[-1])
        run = pushed(self.rom, self.rom.encode(start), grid, signals)
        found, shown, values = [], [], signals.value(grid)
        seconds = time.perf_counter() - began
        for watch in watches:
            at = np.searchsorted(grid, watch.instants - 0.5 * CLOSE * grid[-1])
            found.append(run.reduced[:, at])
            waves = values[:, :, at].transpose(0, 2, 1)
            shown.append(self._driven(found[-1], waves, signals.load, watch.dofs))
        return _motion(run, tuple(found), shown, seconds)

    def _shapes(
        self,
        reduced: np.ndarray,
        instants: np.ndarray,
        drive: Drive | None,
        dofs: np.ndarray | None,
    ) -> tuple[Any, float]:
        """Displacements (b, m, k) of reduced states (b, m, r), and seconds."""
        if drive is None:
            return decoded(self, reduced, dofs)
        angle = (drive.frequency[:, None] * instants)[..., None]
        waves = np.concatenate([np.sin(angle), np.cos(angle)], axis=2)
        waves = waves * drive.amplitude[:, None, None]
        return self._driven(reduced, waves, self.load[None], dofs)

    def _driven(
        self, reduced: np.ndarray, waves: np.ndarray, loads: np.ndarray, dofs: np.ndarray | None
    ) -> tuple[Any, float]:
        """The same under loads (k, n), whose signals are (b, m, k w) waves (`Driven`)."""
        driven = Driven(self, self.rom, loads, waves.shape[2])
        return decoded(driven, np.concatenate([reduced, waves], axis=2), dofs)

    def return_map(self) -> FlowMap:
        """See `Model.return_map`."""
        from vibrom.solvers.periodic.flow_map import FlowMap, odd

        rom, load = self.rom, self.known_load

        def force(z: np.ndarray) -> np.ndarray:
            return rom.force_map(z, load)

        def beside_along(z: np.ndarray) -> np.ndarray | None:
            added = rom.beside(z, load)
            return None if added is None else added @ load

        return FlowMap(
            field=rom.field(load),
            drift=rom.drift,
            force=force,
            encode=rom.encode,
            decode=rom.decode,
            displacement=lambda z: rom.displacement(z, self.probes),
            beside=lambda z: rom.beside(z, load, self.probes),
            along=lambda z: rom.displacement(z) @ load,
            beside_along=beside_along,
            load=load,
            reach=rom.reach,
            frequency=self.frequency,
            parts=2 if odd(rom.drift, force, rom.reach) else 1,
        )

    def decoded(self, coordinates: np.ndarray, dofs: np.ndarray | None = None) -> np.ndarray:
        """Displacements (*batch, n), or (*batch, k) at `dofs` [m], of coordinates (*batch, r)."""
        flat = coordinates.reshape(-1, coordinates.shape[-1])
        chunk = max(1, min(4096, AT_A_TIME // (self.size if dofs is None else len(dofs))))
        flat = decode_displacement(self.rom, flat, dofs, chunk)
        return flat.reshape(*coordinates.shape[:-1], -1)


def _motion(
    run: Any, reduced: tuple[np.ndarray, ...], shown: list[tuple[Any, float]], seconds: float
) -> Motion:
    """Of a rollout that took so many seconds, with the displacements of each watch and theirs."""
    displacement, decoding = zip(*shown)
    ended = np.array(run.outcome, dtype=object), run.failed_at, run.range_ratio
    return Motion(displacement, reduced, *ended, None, seconds + sum(decoding))
