"""A fitted model as MLflow's pyfunc: give it a recorded decay, and it predicts that decay.

    mlflow.pyfunc.load_model(<model>).predict(<.../full_order/test.nc>)

is the displacement (time, dof) [m] from the first recorded state, as a data frame over the time
since release [s]; bit for bit what the scores of the run are computed from.
"""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import NamedTuple

import pandas as pd
import xarray as xr

from vibrom.artefacts.data import open_dataset
from vibrom.experiments import Given
from vibrom.experiments.decay import Decay
from vibrom.models.reduced import Integrator, Reduced
from vibrom.models.rom import rom_from_dataset

LOAD = (
    'Predict a decay with it: `mlflow.set_tracking_uri("sqlite:///results/mlflow.db"); '
    'mlflow.pyfunc.load_model("models:/{identity}").predict('
    '"results/<scene>/full_order/test.nc")`'
)
NAMES = {"rom": "rom.nc", "structure": "structure.nc", "settings": "settings.json"}


class Parts(NamedTuple):
    """What the model is made of: two artefacts, and the settings of its decay."""

    rom: str
    structure: str
    settings: dict  # of the experiment and the integrator, as the artefact of the decay has them
    samples: int  # of a period of the record


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


def save(parts: Parts, home: Path) -> None:
    """A model's folder, as MLflow has it."""
    from mlflow import pyfunc

    data = home.parent / "parts"
    data.mkdir()
    for name in ("rom", "structure"):
        shutil.copyfile(getattr(parts, name), data / NAMES[name])
    settings = parts.settings | {"samples": parts.samples}
    (data / NAMES["settings"]).write_text(json.dumps(settings, sort_keys=True))
    # Named here, or MLflow would start a process to find out.
    needs = ["vibrom"]
    pyfunc.save_model(
        str(home), loader_module=__name__, data_path=str(data), pip_requirements=needs
    )
