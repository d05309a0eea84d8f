"""The configuration of a run: config.yaml, what is laid over it, its scenes and methods.

Every wrong entry is one `SettingsError` of one line that names the file, the dotted key, the value
and the cure. What comes out is complete and of one form, so that an edit which means nothing (other
order of keys, 100 for 100.0) makes nothing again. Nothing numerical is imported.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from vibrom.config import plugs, reading
from vibrom.config.check import checked
from vibrom.config.kinds import Device, Folder, Name, Seed, Several
from vibrom.config.layers import COMMAND, Layers, Sources
from vibrom.config.method_file import MethodFile
from vibrom.config.places import FULL_ORDER, UNSEEDED
from vibrom.config.recorded import RecordedScene
from vibrom.config.scene import Block, Scene

# Names of other folders of the results.
TAKEN = {
    "scenes": ("tables", "figures", "logs", "benchmarks", "mlflow_artifacts"),
    "methods": (FULL_ORDER,),
}
INTEGRATOR = ("vibrom.models.rollout", "Integrator")  # the class that declares its settings


class Config(Block, frozen=True):
    """config/config.yaml with what is laid over it."""

    results: Folder  # the folder of all artefacts
    scenes: Several[Name]  # each a file in config/scenes
    methods: Several[Name]  # each a file in config/methods
    seeds: Several[Seed]  # one model is trained from each
    experiments: Several[Name]  # the questions put to every model
    integrator: dict[str, Any]  # of the reduced models
    device: Device = "cpu"  # where networks are trained: cpu, cuda, cuda:1, ..., or auto
    studies: dict[Name, dict[str, Any]] = {}  # the studies that run, with their settings
    scene_settings: dict[Name, dict[str, Any]] = {}  # over config/scenes, by scene or for all
    method_settings: dict[Name, dict[str, Any]] = {}  # over config/methods, by method


@dataclass(frozen=True)
class Settings:
    """A checked configuration. Scenes and methods are complete: files and overlays merged."""

    results: str
    scenes: dict[str, Scene | RecordedScene]
    methods: dict[str, MethodFile]
    seeds: list[int]
    experiments: list[str]
    integrator: dict[str, Any]
    device: str
    studies: dict[str, dict[str, Any]]

    def seed_folders(self, method: str) -> list[str]:
        """`seed_0`, `seed_1`, ..., or `unseeded` for a method that is fitted once."""
        seeded = self.methods[method].seeded
        return [f"seed_{seed}" for seed in self.seeds] if seeded else [UNSEEDED]

    def kind_of(self, method: str) -> str:
        """The file of src/vibrom/methods behind a method."""
        return self.methods[method].method or method

    def start_of(self, method: str, folder: str) -> tuple[str, str] | None:
        """Method and seed folder of the model that this one starts from."""
        start = self.methods[method].starts_from
        if start is None:
            return None
        return start, folder if self.methods[start].seeded else UNSEEDED

    def asked(self, scene: str) -> list[str]:
        """The experiments of the run in which a scene takes part."""
        return [name for name in self.experiments if name in self.scenes[scene].experiments]

    def modules_of(self, scene: str) -> list[str]:
        """The modules of a scene's body, effects and time integration, below vibrom; none of a
        recorded one.
        """
        made = self.scenes[scene]
        if isinstance(made, RecordedScene):
            return []
        own = f"bodies.{made.body['shape']}", f"solvers.full.schemes.{made.time.scheme}"
        return [*own, *(f"effects.{name}" for name in made.effects)]

    def signals_of(self, scene: str) -> list[str]:
        """The modules of the signals that drive its loads, below vibrom."""
        made = self.scenes[scene]
        entries = [] if isinstance(made, RecordedScene) else list(made.effects.values())
        loads = [
            one for entry in entries for one in (entry if isinstance(entry, list) else [entry])
        ]
        names = {name for one in loads for name in one.get("signal") or ()}
        return [f"signals.{name}" for name in sorted(names)]


def load(
    folder: Path,
    files: Iterable[str | Path] = (),
    command: Mapping[str, Any] | None = None,
    origin: str = COMMAND,
) -> Settings:
    """The settings of a run: config.yaml of `folder`, with files and then values of the command
    line, or of another `origin`, laid over it.
    """
    sources = Sources([folder / "config.yaml", *files], command or {}, origin)
    layers = sources.config()
    config = checked(layers.content, plugs.declared(__name__, "Config"), (), layers.refuse)
    for kind in ("scenes", "methods"):
        known, single = reading.stems(folder, kind), kind.removesuffix("s")
        sources.check_names(f"{single}_settings", known)
        for place, name in enumerate(config[kind]):
            layers.check_known((kind, place), name, known, single)
            if name in TAKEN[kind]:
                cure = "is the name of another folder of the results; rename its file"
                layers.refuse((kind, place), name, cure)
    for place, name in enumerate(config["experiments"]):
        layers.check_known(("experiments", place), name, plugs.names("experiments"), "experiment")
    asked = reading.needed(config["experiments"], config["studies"])
    scenes = {name: reading.scene(sources, folder, name, asked) for name in config["scenes"]}
    methods = {name: reading.method(sources, folder, name) for name in config["methods"]}
    reading.check_starts(methods, folder)
    return Settings(
        results=_normal(config["results"], layers),
        scenes=scenes,
        methods=methods,
        integrator=reading.block(layers, ("integrator",), plugs.declared(*INTEGRATOR)),
        studies={
            name: reading.study(layers, name, folder, scenes, methods) for name in config["studies"]
        },
        **{key: config[key] for key in ("seeds", "experiments", "device")},
    )


def _normal(results: str, layers: Layers) -> str:
    """One spelling of a folder, as Snakemake knows files by the spelling of their paths."""
    path = os.path.normpath(os.path.expanduser(results))
    if path == "." or path.startswith("~"):
        layers.refuse(("results",), results, "is no folder of results; name one")
    here = os.getcwd() + os.sep
    return path.removeprefix(here)
