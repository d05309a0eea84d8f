"""A fitted model as MLflow's pyfunc: give it a recorded decay, and it predicts that decay.

    mlflow.pyfunc.load_model(<model>).predict(<.../full_order/test.nc>)

is the displacement (time, dof) [m] from the first recorded state, as a data frame over the time
since release [s]; bit for bit what the scores of the run are computed from.
"""

from __future__ import annotations

import json
from pathlib import Path

import pandas as pd
import xarray as xr

from vibrom.artefacts.data import open_dataset
from vibrom.experiments import Given
from vibrom.experiments.decay import Decay
from vibrom.models.reduced import Integrator, Reduced
from vibrom.models.rom import rom_from_dataset
from vibrom.tracking.stored_model import NAMES


class DecayModel:
    """What `load_model` wraps."""

    def __init__(self, folder: Path):
        chosen = json.loads((folder / NAMES["settings"]).read_text())
        self.structure = open_dataset(folder / NAMES["structure"], "structure")
        self.rom = rom_from_dataset(open_dataset(folder / NAMES["rom"], "rom"))
        self.integrator = Integrator(**(chosen["integrator"] or {}))
        self.question, self.samples = Decay(**chosen["experiment"]), chosen["samples"]

    def predict(self, record: str | Path | xr.Dataset, params: dict | None = None) -> pd.DataFrame:
        """Of a recorded decay: where it lies, or the dataset."""
        if not isinstance(record, xr.Dataset):
            record = open_dataset(record, "trajectory")
        model = Reduced.of_scene(self.rom, self.structure, self.integrator)
        given = Given(self.structure, self.samples, {"test": record})
        answer = self.question.ask(model, given)
        time = pd.Index(answer["time"].values, name="time [s]")
        return pd.DataFrame(answer["displacement"].values, index=time)


def _load_pyfunc(folder: str) -> DecayModel:
    """MLflow calls this."""
    return DecayModel(Path(folder))
