"""How strong an unknown load is, from one measured response or from a motion under a known signal.

    dz/dt = drift(z) + s force_map(z, p) sin(Omega t),    z periodic,    half range of y = A

y is the displacement at a probe, A its measured amplitude. The strength s and the Fourier
coefficients of z are found together by collocation at equal instants of a period; the first guess
is one harmonic. Of a motion z(t) that was recorded with its signals u_k(t), least squares have

    s = sum_t g'(dz/dt - drift(z)) / sum_t g'g,    g = sum_k force_map(z, p_k) u_k(t)

Known from one response or motion, s holds for all frequencies. Source: Cenedese, Axas,
Bauerlein, Avila, Haller, Nature Communications 13 (2022) 872.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr

from vibrom.models.recorded import FIRST, differences
from vibrom.models.rom import Rom
from vibrom.models.training import Unsupported

HARMONICS = 7
INSTANTS = 2 * HARMONICS + 1  # as many as there are coefficients
CLOSE = 1e-12  # relative change of the last step
ACCEPTED = 1e-6  # what is left, of the measured amplitude and of the rates


@dataclass(frozen=True)
class Calibration:
    """One measured response."""

    frequency: float  # rad/s, of the load
    amplitude: float  # m, half the range of the displacement
    dof: int  # displacement that was measured

    @classmethod
    def of_scene(cls, known: xr.Dataset) -> Calibration:
        """The point that the structure names."""
        at = int(known["calibration_point"])
        frequency, amplitude = (
            float(known[f"response_{name}"].values[at]) for name in ("frequency", "amplitude")
        )
        return cls(frequency, amplitude, int(known["response_dof"]))

    def strength(self, rom: Rom, load: np.ndarray) -> float:
        """s, in units of the load (n,); Unsupported where the model has no such response."""
        fourier, slopes = _matrices()
        unit = rom.reach * 1e-4
        size, d = len(unit), len(unit) // 2

        def probe(z: np.ndarray) -> np.ndarray:
            return rom.displacement(z, np.array([self.dof]))[..., 0]

        def motion(unknown: np.ndarray) -> np.ndarray:
            return (fourier @ unknown[:-1].reshape(-1, size)) * scale

        def residual(unknown: np.ndarray) -> np.ndarray:
            z, s = motion(unknown), unknown[-1] * guess
            rate = self.frequency * slopes @ unknown[:-1].reshape(-1, size) * scale
            push = s * rom.force_map(z, load) * np.sin(_angles())[:, None]
            off = (rate - rom.drift(z) - push) / (scale * self.frequency)
            seen = probe(_finer() @ unknown[:-1].reshape(-1, size) * scale)
            return np.append(off.ravel(), 0.5 * np.ptp(seen) / self.amplitude - 1.0)

        step = np.eye(size)[0] * unit[0]
        per_coordinate = (probe(step) - probe(-step)) / (2.0 * unit[0])
        if per_coordinate == 0.0:
            raise Unsupported(
                "the measured channel does not move with the model's first coordinate"
            )
        swing = self.amplitude / abs(per_coordinate)
        scale = np.repeat([swing, swing * self.frequency], d)
        first, guess = self._guess(rom, load, swing)
        start = np.append((np.linalg.inv(fourier) @ (first / scale)).ravel(), 1.0)
        from scipy.optimize import least_squares  # slow to import, and most loads are known

        found = least_squares(residual, start, xtol=CLOSE, ftol=CLOSE, gtol=CLOSE)
        if np.abs(found.fun).max() > ACCEPTED:
            raise Unsupported(
                f"the model has no response of {self.amplitude:.4g} m at {self.frequency:.5g} "
                "rad/s from which the load could be calibrated"
            )
        return float(found.x[-1] * guess)

    def _guess(self, rom: Rom, load: np.ndarray, swing: float) -> tuple[np.ndarray, float]:
        """Motion (m, 2d) in the first coordinate alone, and the strength that balances it in its
        first harmonic.
        """
        d, angle = len(rom.reach) // 2, _angles()

        def harmonic(phase: np.ndarray) -> np.ndarray:
            z = np.zeros((len(phase), 2 * d))
            z[:, 0], z[:, d] = swing * np.cos(phase), -swing * self.frequency * np.sin(phase)
            return z

        z = harmonic(angle)
        missing = -swing * self.frequency**2 * np.cos(angle) - rom.drift(z)[:, d]
        even, odd = (2.0 * np.mean(missing * wave(angle)) for wave in (np.cos, np.sin))
        push = abs(float(rom.force_map(np.zeros(2 * d), load)[d]))
        if push == 0.0:
            raise Unsupported("the load does not move the first coordinate of this model")
        return harmonic(angle - np.arctan2(even, odd)), float(np.hypot(even, odd)) / push


@dataclass(frozen=True)
class Signalled:
    """Motions under recorded signals."""

    time: np.ndarray  # (m,) s
    part: np.ndarray  # (m,) number of the recording
    state: np.ndarray  # (m, 2n) m, m/s
    signal: np.ndarray  # (m, k)
    loads: np.ndarray  # (k, n) per unit of each signal

    @classmethod
    def of_scene(cls, known: xr.Dataset) -> Signalled:
        """Those recordings that the structure says calibrate."""
        own = known.isel(signal_sample=known["signal_calibrates"].values == 1)
        state = [own[f"signal_{name}"].values for name in ("displacement", "velocity")]
        time, part, signal, loads = (
            own[f"signal_{name}"].values for name in ("time", "part", "value", "load")
        )
        return cls(time, part, np.concatenate(state, axis=1), signal, loads)

    def strength(self, rom: Rom, load: np.ndarray) -> float:
        """s, in units of the loads; Unsupported where they do not move this model."""
        d, above, below = len(rom.reach) // 2, 0.0, 0.0
        for number in np.unique(self.part):
            own = self.part == number
            z, step = rom.encode(self.state[own]), float(np.diff(self.time[own][:2])[0])
            rate, inner = differences(z, step)[0], slice(len(FIRST) // 2, -(len(FIRST) // 2))
            z, signal = z[inner], self.signal[own][inner]
            push = sum(rom.force_map(z, p) * u[:, None] for p, u in zip(self.loads, signal.T))
            left, push = ((part / rom.reach)[:, d:] for part in (rate - rom.drift(z), push))
            above, below = above + float((push * left).sum()), below + float((push**2).sum())
        if below == 0.0:
            raise Unsupported("the load does not move the coordinates of this model")
        return above / below


def calibration(known: xr.Dataset) -> Calibration | Signalled | None:
    """What the structure says; None where the load is known, or nothing is."""
    if "signal_calibrates" in known and known["signal_calibrates"].values.any():
        return Signalled.of_scene(known)
    return Calibration.of_scene(known) if "calibration_point" in known else None


def _angles() -> np.ndarray:
    return 2.0 * np.pi * np.arange(INSTANTS) / INSTANTS


def _waves(angle: np.ndarray) -> np.ndarray:
    multiples = np.arange(1, HARMONICS + 1)
    turned = angle[:, None] * multiples
    return np.hstack([np.ones((len(angle), 1)), np.cos(turned), np.sin(turned)])


def _matrices() -> tuple[np.ndarray, np.ndarray]:
    """Values and slopes (m, m) at the instants, of a constant, cosines and sines."""
    angle, multiples = _angles(), np.arange(1, HARMONICS + 1)
    turned = angle[:, None] * multiples
    slopes = np.hstack(
        [np.zeros((len(angle), 1)), -multiples * np.sin(turned), multiples * np.cos(turned)]
    )
    return _waves(angle), slopes


def _finer() -> np.ndarray:
    """Values at instants so close that the largest is missed by (pi/256)^2/2 = 8e-5 of it."""
    return _waves(2.0 * np.pi * np.arange(256) / 256)
