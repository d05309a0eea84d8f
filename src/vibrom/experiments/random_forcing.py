"""Spectra of the motion under random forcing from rest:

    M a + C v + K q + sum f(q, v) = p u(t) + p_0
    S(w) = 2/pi int_0^inf E[q(t) q(t + s)] cos(w s) ds

with Gaussian noise u of a flat spectrum in a band (`signals/noise.py`), the same realisations for
every model, from their seeds. S is the one-sided spectral density at a probe by Welch's method:
Hann's windows that overlap by half, averaged over all realisations that went to the end; its
relative standard error is about one over the root of their number. Source: Welch, IEEE Trans. Audio
Electroacoust. 15 (1967) 70.
"""

from dataclasses import dataclass, replace

import numpy as np
import xarray as xr
from scipy.signal import welch

from vibrom.artefacts.data import outcome_variables, variable
from vibrom.artefacts.outcome import Outcome
from vibrom.config.kinds import Count, NonNegative, Positive, Seed, Tolerance, Whole
from vibrom.experiments import Experiment, Given, at_rest
from vibrom.models.balance import balance_variable, checked
from vibrom.models.model import Model, Signals, Watch
from vibrom.signals.noise import Noise


@dataclass(frozen=True)
class RandomForcing(Experiment):
    """One level, some realisations side by side."""

    forcing: Positive  # standard deviation of the noise, times the scene's load
    lowest: NonNegative = 0.0  # of the band, times the damped first frequency
    highest: Positive = 2.0  # of the band, times the damped first frequency
    realisations: Count = 8  # whose seeds count upwards
    seed: Seed = 0  # of the first one
    periods: Count = 200  # of the damped first mode, that the spectrum is of
    settle: Whole = 50  # periods before them
    windows: Count = 7  # of each realisation
    balance: Tolerance = 0.01  # relative error of energy, work and losses, where that is known

    scores = {
        "completed": "1",
        "spectrum_error_db": "dB",
        "deviation_error_percent": "percent",
        "peak_frequency_error_percent": "percent",
    }
    truth = "random_forcing"
    where_set = True

    def brief(self) -> "RandomForcing":
        """Two periods."""
        return replace(self, periods=2, settle=0, windows=1)

    def ask(self, model: Model, given: Given) -> xr.Dataset:
        """Spectrum and standard deviation at every probe."""
        period, first = 2.0 * np.pi / model.frequency, self.settle * given.samples
        instants = period * np.arange(first + self.periods * given.samples) / given.samples
        drive = self.drive(model, given.structure)
        runs = self.realisations
        motion = model.motion(at_rest(model, runs), drive, Watch(instants, model.probes))
        ended = checked(motion.outcome, motion.balance, self.balance)
        seen = motion.displacement[0][:, first:].transpose(0, 2, 1)  # (runs, probes, instants)
        length = max(2 * seen.shape[-1] // (self.windows + 1), 2)
        rate = given.samples / period
        frequency, density = welch(seen, rate, nperseg=length, noverlap=length // 2, detrend=False)
        lasts = np.isfinite(seen).all(axis=(1, 2))
        spectrum = density[lasts].mean(axis=0) if lasts.any() else np.full_like(density[0], np.nan)
        inside = frequency <= self.highest * model.frequency / (2.0 * np.pi) * (1.0 + 1e-9)
        answer = {
            "spectral_density": variable(
                ("probe", "angular_frequency"),
                spectrum[:, inside] / (2.0 * np.pi),
                "m2 s rad-1",
                "one-sided spectral density of the displacement",
            ),
            "deviation": variable(
                ("realisation", "probe"), seen.std(axis=2), "m", "standard deviation"
            ),
            "forcing": variable(
                (), float(self.forcing), "1", "standard deviation, times the scene's load"
            ),
            **outcome_variables(Outcome.OK, seconds=motion.seconds),
            **balance_variable(("realisation",), motion.balance),
            "outcome": variable("realisation", ended, "1", "how the motion ended"),
            "failed_at": variable(
                "realisation", motion.failed_at, "s", "when it failed or left the training range"
            ),
        }
        coords = {
            "angular_frequency": variable(
                "angular_frequency", 2.0 * np.pi * frequency[inside], "rad s-1", "of the motion"
            ),
            "probe": given.probe,
            "realisation": variable("realisation", self._seeds, "1", "seed"),
        }
        return xr.Dataset(answer, coords=coords)

    @property
    def _seeds(self) -> list[int]:
        return list(range(self.seed, self.seed + self.realisations))

    def drive(self, model: Model, known: xr.Dataset) -> Signals:
        """Noise on the scene's load, of each realisation."""
        band = self.lowest * model.frequency, self.highest * model.frequency
        noise = Noise(lowest=band[0], highest=band[1], deviation=self.forcing, seed=self.seed)
        return Signals(
            known["load"].values[None], lambda t: noise.realised(t, self._seeds)[:, None]
        )

    def score(self, answer: xr.Dataset, truth: xr.Dataset) -> dict[str, float]:
        """Of the first probe, over the band: median distance of the spectra, and errors of the
        standard deviation of all realisations and of the frequency at the peak.
        """
        both = [item["spectral_density"].values[0] for item in (answer, truth)]
        frequency = answer["angular_frequency"].values
        inside = (frequency > 0.0) & (frequency >= self.lowest / self.highest * frequency[-1])
        spectrum, true = (values[inside] for values in both)
        deviation, known = (
            np.sqrt(np.mean(item["deviation"].values[:, 0] ** 2)) for item in (answer, truth)
        )
        finite = np.isfinite(spectrum).all() and np.isfinite(true).all()
        peaks = [
            frequency[inside][values.argmax()] if finite else np.nan for values in (spectrum, true)
        ]
        return {
            "completed": float(np.isfinite(answer["deviation"].values[:, 0]).sum()),
            "spectrum_error_db": float(np.median(np.abs(10.0 * np.log10(spectrum / true)))),
            "deviation_error_percent": float(100.0 * (deviation / known - 1.0)),
            "peak_frequency_error_percent": float(100.0 * (peaks[0] / peaks[1] - 1.0)),
        }
