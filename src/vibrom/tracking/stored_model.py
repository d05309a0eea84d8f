"""A fitted model as it lies in the store: a folder that MLflow loads by `decay_model`."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import NamedTuple

LOAD = (
    'Predict a decay with it: `mlflow.set_tracking_uri("sqlite:///results/mlflow.db"); '
    'mlflow.pyfunc.load_model("models:/{identity}").predict('
    '"results/<scene>/full_order/test.nc")`'
)
LOADER = "vibrom.tracking.decay_model"  # by name: what loads a model is not behind the store
NAMES = {"rom": "rom.nc", "structure": "structure.nc", "settings": "settings.json"}


class Parts(NamedTuple):
    """What the model is made of: two artefacts, and the settings of its decay."""

    rom: str
    structure: str
    settings: dict  # of the experiment and the integrator, as the artefact of the decay has them
    samples: int  # of a period of the record


def save(parts: Parts, home: Path) -> None:
    """A model's folder, as MLflow loads it; the packages that it needs are those of this project,
    which `pyfunc.save_model` would look through for each model again.
    """
    from mlflow import pyfunc
    from mlflow.models import Model

    data = home / "data"
    data.mkdir(parents=True)
    for name in ("rom", "structure"):
        shutil.copyfile(getattr(parts, name), data / NAMES[name])
    settings = parts.settings | {"samples": parts.samples}
    (data / NAMES["settings"]).write_text(json.dumps(settings, sort_keys=True))
    (home / "requirements.txt").write_text("vibrom\n")
    model = Model()
    pyfunc.add_to_model(model, loader_module=LOADER, data=data.name)
    model.save(home / "MLmodel")
