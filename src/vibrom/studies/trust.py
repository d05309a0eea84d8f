"""How well models obey the equations of motion, before any truth is seen.

    e = |A^-1 r| / max |q|,    r the residual of the model's own motion

(`models.trust`). It is evaluated along ellipses of growing amplitude, where one reduced oscillator
moves, and in the first period of the model's own decay from the test release. A model is trusted up
to the largest displacement at which e stays within a tolerance. Beside that stands the work balance
(`models.balance`) of its decay and, from rest, of the scene's forced run, of its motion under loads
with signals, and of one under random forcing, where the scene has them.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Annotated, Any

import numpy as np
import xarray as xr
from msgspec import Meta

from vibrom.artefacts.data import variable
from vibrom.artefacts.identity import FITTED_ONCE
from vibrom.artefacts.outcome import Outcome
from vibrom.config.kinds import Count, Positive, Tolerance
from vibrom.models.balance import SAMPLES, of_motion
from vibrom.models.full_order import FullOrder
from vibrom.models.model import Drive, Push, Signals, Watch
from vibrom.models.reduced import Reduced
from vibrom.models.rollout import Integrator, rollout
from vibrom.models.rom import Rom, rom_from_dataset
from vibrom.models.training import Unsupported
from vibrom.models.trust import PHASES, Residual, ellipse, equation_error, trusted
from vibrom.studies import Case, Fitted, Study
from vibrom.studies.parts.records import Column, stacked, text

AMPLITUDE = ("amplitude",)
COLUMNS = {
    "model": Column("1", "method", missing=""),
    "model_seed": Column("1", "seed, -1 where it is fitted once"),
    "outcome": Column("1", "how the fit ended", missing=Outcome.NOT_RUN),
    "error": Column("percent", "error of the equations of motion", AMPLITUDE),
    "displacement": Column("m", "largest displacement of the ellipse", AMPLITUDE),
    "probe_displacement": Column("m", "the same of the first probe", AMPLITUDE),
    "trusted_displacement": Column("m", "largest displacement up to which the model is trusted"),
    "trusted_probe_displacement": Column("m", "the same of the first probe"),
    "release_error": Column("percent", "error in the first period of the test decay"),
    "release_displacement": Column("m", "largest displacement of that period"),
    "decay_balance": Column("1", "relative error of energy and losses of the decay"),
    **{
        f"{run}_balance": Column("1", f"relative error of energy, work and losses, {words}")
        for run, words in (
            ("forced", "driven by a sine"),
            ("response", "under loads with signals"),
            ("random_forcing", "under random forcing"),
        )
    },
}


@dataclass(frozen=True)
class Trust(Study):
    """Amplitudes are multiples of the largest one in the training data, or, of a model that has
    none, of what it is trusted to by itself.
    """

    amplitudes: Annotated[list[Positive], Meta(min_length=1)]  # ascending; none is tried beyond
    tolerance: Tolerance  # of e
    periods: Count = 30  # of the runs whose work balance is taken

    jobs = {"models": "trust"}
    reads = {"models": ("full_order/release",)}
    experiments = ("forced", "response", "random_forcing")

    def of_models(self, case: Case) -> xr.Dataset:
        """One entry a model."""
        full = FullOrder.of_scene(dict(case.scene), case.structure)
        records = list(self._records(case, full, Residual(full.term)))
        count = len(self.amplitudes)
        multiples = np.array(self.amplitudes)
        return xr.Dataset(
            stacked(records, {"fit": len(records)}, COLUMNS, {AMPLITUDE[0]: count}),
            coords={
                AMPLITUDE[0]: variable(AMPLITUDE[0], multiples, "1", "amplitude over the range"),
                "fit": text("fit", range(len(records)), "number of the fit"),
            },
            attrs={"tolerance": self.tolerance},
        )

    def _records(self, case: Case, full: FullOrder, residual: Residual) -> Iterator[dict[str, Any]]:
        shape = case.full_order["release"]["displacement"].sel(role="test").values
        start = np.concatenate([shape, np.zeros_like(shape)])
        for model in case.fitted:
            record = {
                "model": model.record.attrs["method"],
                "model_seed": int(model.record.attrs.get("seed", FITTED_ONCE)),
                "outcome": model.outcome,
            }
            if model.outcome.has_value:
                with np.errstate(all="ignore"):
                    record |= self._measured(case, full, residual, start, model)
            yield record

    def _measured(
        self, case: Case, full: FullOrder, residual: Residual, start: np.ndarray, model: Fitted
    ) -> dict[str, Any]:
        rom = rom_from_dataset(model.record)
        probe = full.probes[0]

        def error(amplitude: float) -> float:
            return equation_error(residual, rom, ellipse(rom.reach, 0, amplitude))

        def largest(amplitude: float) -> tuple[float, float]:
            return swing(rom, ellipse(rom.reach, 0, amplitude), probe)

        found = np.array([largest(amplitude) for amplitude in self.amplitudes])
        amplitude = trusted(error, self.tolerance, max(self.amplitudes))
        up_to = largest(amplitude)
        times = full.period * np.arange(PHASES) / PHASES
        integrator = Integrator(**case.integrator)
        balances = self._balances(
            case, full, start, Reduced.of_scene(rom, case.structure, integrator)
        )
        decay = rollout(rom, rom.encode(start[None]), times[None], integrator)
        states = decay.reduced[0]
        return {
            "error": 100.0 * np.array([error(amplitude) for amplitude in self.amplitudes]),
            "displacement": found[:, 0],
            "probe_displacement": found[:, 1],
            "trusted_displacement": up_to[0],
            "trusted_probe_displacement": up_to[1],
            "release_error": 100.0 * equation_error(residual, rom, states),
            "release_displacement": swing(rom, states, probe)[0],
            **balances,
        }

    def _balances(
        self, case: Case, full: FullOrder, start: np.ndarray, model: Reduced
    ) -> dict[str, float]:
        """Of the test decay, and of the runs from rest that the scene has. Signals that may jump
        are seen as often as the model sees them.
        """
        found = {}
        for run in ("decay", *self.experiments):
            if run != "decay" and run not in case.scene["experiments"]:
                continue
            with suppress(Unsupported):
                drive = self._drive(case, run, full)
                samples = full.samples if isinstance(drive, Signals) else SAMPLES
                watch = Watch(full.period * np.arange(self.periods * samples + 1) / samples)
                state = start[None] if run == "decay" else np.zeros((1, len(start)))
                motion = model.motion(state, drive, watch).displacement[0][0]
                asked = full.term, full.rest, full.period, drive, motion, samples
                found[f"{run}_balance"] = of_motion(*asked)
        return found

    def _drive(self, case: Case, run: str, full: FullOrder) -> Push:
        if run == "decay":
            return None
        if run == "forced":
            forcing = np.array([float(case.settings(run)["forcing"])])
            return Drive(forcing, np.array([full.frequency]))
        question: Any = case.question(run)
        if run == "random_forcing":
            question = replace(question, realisations=1)
        drive: Signals = question.drive(full, case.structure)
        return drive


def swing(rom: Rom, z: np.ndarray, probe: int) -> tuple[float, float]:
    """Largest displacement of all, and of a probe [m], of states z (m, 2d)."""
    q = np.abs(rom.displacement(z))
    return float(q.max()), float(q[:, probe].max())
