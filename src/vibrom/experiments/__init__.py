"""One file an experiment: a question put to a model.

needs        artefacts it reads of a reduced model: structure, rom, losses; train, test, forced, frc
of the full-order model; or the
             dataset of another experiment for the same model, by its name
full_order   what it reads when the full-order model is asked, or None where it is not
scores       name -> unit of the numbers that it gives; a model that could not be asked has none of
them predict(artefacts, integrator) -> Dataset with its scores
"""

import importlib
from types import ModuleType


def load(name: str) -> ModuleType:
    return importlib.import_module(f"vibrom.experiments.{name}")
