"""The real steps in one process, over a beam of a few elements and a few periods: what tables and
figures are tested on.
"""

from importlib import import_module
from pathlib import Path

import numpy as np

from vibrom.config import plugs, settings
from vibrom.report.collection import Collection, Key

ROOT = Path(__file__).parents[2]
PROVENANCE = {"source_digest": "0123456789abcdef", "versions": '{"numpy": "2.0"}'}
OVERLAY = """
scenes: [small, large]
methods: [modal_projection, split, split_plus]
seeds: [0, 1]
experiments:
  [reconstruction, decay, backbone, forced, frc, branches, s_curve, resonance, sweeps, eigenvalues,
   run_times, response, random_forcing]
integrator: {rtol: 1.0e-4, atol: 1.0e-6}
scene_settings:
  all:
    body:
      cells: [8, 2]
      probes: {probe: {at: [0.5, 0.0]}}
    record: {periods: 4}
    experiments:
      forced: {forcing: 100.0, periods: 3}
      frc: {forcing: 100.0, periods: 2, frequencies: 9}
    time: {steps_per_period: 100, every: 2}
  small:
    releases: {train: {forcing: 200.0, step: 250}, test: {forcing: 200.0, step: 200}}
  large:
    releases: {train: {forcing: 600.0, step: 250}, test: {forcing: 600.0, step: 200}}
    experiments:
      branches: {forcing: 100.0, lowest: 0.9, highest: 1.1, points: 12}
      s_curve: {frequency: 1.0, forcing: 100.0, points: 6}
      resonance: {forcing: 100.0, points: 6}
      sweeps: {forcing: 100.0, periods: 2, longest: 2, frequencies: 3}
      response: {periods: 3}
      random_forcing: {forcing: 50.0, realisations: 2, periods: 4, settle: 0, windows: 1}
    effects:
      point_load: {at: [1.0, 0.01], direction: y, signal: {pulse: {duration: 0.005, size: 20.0}}}
method_settings:
  split: {epochs: 2, rank: 6}
studies:
  ablation: {decay_periods: 2, forced_periods: 2, timed_periods: 1, repeats: 1}
  cost:
    scenes: [large]
    repeats: 1
    full_order:
      schemes: [{alpha: 0.0, initial_acceleration: equilibrium}]
      steps_per_period: [50, 100]
      residuals: [1.0e-4]
      forced_periods: 1
      reference: {steps_per_period: 400, residual: 1.0e-8}
      meshes: {bilinear: [[4, 1], [8, 2]], quadratic: [[4, 1]]}
      reference_mesh: {element: quadratic, cells: [8, 2]}
      mesh_periods: 1
      mesh_steps_per_period: 100
    reduced:
      modal_projection: []
      ssmlearn: null
      ssmlearn_11: null
      decoupled_autoencoder: null
      sindy_autoencoder: null
      split: []
      split_plus: [{vary: [rtol], over: [1.0e-3]}]
  robustness:
    scenes: [large]
    guards: {none: {}, bounded: {extrapolation: linear}, dissipative: null, dissipative_9: null}
    integrators: {tight: {rtol: 1.0e-4, atol: 1.0e-6}, loose: null, implicit: null}
    forcing: [1.0]
    frequency: {count: 2}
    periods: 2
    releases: 2
    full_order: {steps_per_period: [50], schemes: [{alpha: 0.0}], periods: 2, every_frequency: 4}
"""
DIVERGES = ("large", "split_plus", 1)  # whose training ends in infinity


class SmallRun:
    """`paths` are the artefacts, in the order of the workflow."""

    def __init__(self, folder: Path):
        overlay = folder / "overlay.yaml"
        overlay.write_text(OVERLAY)
        self.settings = settings.load(ROOT / "config", [overlay], {})
        self.results, self.paths = folder / "results", []
        for scene in self.settings.scenes:
            self.full_order(scene)
        for scene in self.settings.scenes:
            for method in self.settings.methods:
                for seed in self.settings.seed_folders(method):
                    self.model(scene, method, seed)
        for name, block in self.settings.studies.items():
            for scene in block.get("scenes", self.settings.scenes):
                self.study(scene, name)

    def step(self, step: str, output: str, path: str, /, **given) -> None:
        """One artefact."""
        made = str(self.results / path)
        run = import_module(f"vibrom.steps.{step}").run
        run(**{output: made}, **given, provenance=PROVENANCE)
        self.paths.append(made)

    def at(self, scene: str, name: str, model: str = "full_order") -> str:
        """Where an artefact lies."""
        return str(self.results / scene / model / f"{name}.nc")

    def full_order(self, scene: str) -> None:
        """Structure, releases, recorded decays, and its answers to the experiments."""
        blocks, home = self.settings.scenes[scene].to_builtins(), f"{scene}/full_order"
        known = {"structure": self.at(scene, "structure")}
        self.step("structure", "structure", f"{home}/structure.nc", scene=blocks, name=scene)
        self.step("release", "release", f"{home}/release.nc", scene=blocks, **known)
        known["release"] = self.at(scene, "release")
        for role in ("train", "test"):
            path = f"{home}/{role}.nc"
            self.step("record", "trajectory", path, scene=blocks, role=role, **known)
        for name in self.in_order(scene):
            if plugs.constants("experiments", name)["of_full_order"]:
                self.ask(scene, "full_order", None, name, scene=blocks)

    def in_order(self, scene: str) -> list[str]:
        """The experiments of a scene, each after those that it reads."""
        return sorted(
            self.settings.asked(scene),
            key=lambda name: len(plugs.constants("experiments", name)["reads"]),
        )

    def ask(self, scene: str, model: str, seed: int | None, name: str, /, **given) -> None:
        """One answer, as workflow/rules/experiments.smk has it."""
        asked = plugs.constants("experiments", name)
        method, full = model.split("/")[0], model == "full_order"
        reads = {need: self.need(scene, model, need) for need in asked["reads"]}
        if full:
            reads = {need: path for need, path in reads.items() if need not in ("train", "fit")}
        elif asked["truth"]:
            given[f"truth_{name}"] = self.need(scene, "full_order", asked["truth"])
        time = self.settings.scenes[scene].time
        self.step(
            "ask",
            name,
            f"{scene}/{model}/{name}.nc",
            questions={
                name: self.settings.scenes[scene].to_builtins()["experiments"].get(name, {})
            },
            names={"scene": scene, "method": method, "seed": seed},
            samples=time.steps_per_period // time.every,
            structure=self.at(scene, "structure"),
            integrator=self.settings.integrator,
            **reads,
            **given,
        )

    def need(self, scene: str, model: str, need: str) -> str:
        """Where lies what an experiment reads."""
        if need in ("train", "test") or (need, model) == ("decay", "full_order"):
            return self.at(scene, "test" if need == "decay" else need)
        return self.at(scene, "rom" if need == "fit" else need, model)

    def model(self, scene: str, method: str, folder: str) -> None:
        """A fitted model and its answers. One training is made to diverge."""
        home, block = f"{scene}/{method}/{folder}", self.settings.methods[method].to_builtins()
        seed = None if folder == "unseeded" else int(folder.removeprefix("seed_"))
        start = self.settings.start_of(method, folder)
        chosen, kind = dict(block["settings"]), self.settings.kind_of(method)
        if (scene, method, seed) == DIVERGES:
            start, kind = None, "split"
            chosen = self.settings.methods["split"].to_builtins()["settings"]
            chosen = chosen | {"learning_rate": 1e30}
        self.paths.append(str(self.results / home / "losses.nc"))
        self.step(
            "fit",
            "rom",
            f"{home}/rom.nc",
            losses=str(self.results / home / "losses.nc"),
            structure=self.at(scene, "structure"),
            train=self.at(scene, "train"),
            recipe={
                "scene": scene,
                "method": method,
                "kind": kind,
                "settings": chosen,
                "seed": seed,
                "device": "cpu",
            },
            start=start and self.at(scene, "rom", "/".join(start)),
        )
        rom = self.at(scene, "rom", f"{method}/{folder}")
        for name in self.in_order(scene):
            self.ask(scene, f"{method}/{folder}", seed, name, rom=rom)

    def study(self, scene: str, name: str) -> None:
        """All artefacts of a study, as workflow/rules/studies.smk has it."""
        about, chosen = plugs.constants("studies", name), self.settings.studies[name]
        models = [
            f"{method}/{folder}"
            for method in self.settings.methods
            for folder in self.settings.seed_folders(method)
        ]
        for kind, artefact in about["jobs"].items():
            reads = about["reads"].get(kind, ())
            own = ["rom", *(need for need in reads if "/" not in need)]
            known = [self.at(scene, need.split("/")[1]) for need in reads if "/" in need]
            asked = {"scene": [[]], "model": [[model] for model in models], "models": [models]}
            for fitted in asked[kind]:
                of_model = fitted[0] if kind == "model" else "full_order"
                method, _, folder = of_model.partition("/")
                seed = folder.removeprefix("seed_")
                self.step(
                    "study",
                    "output",
                    f"{scene}/{of_model}/{artefact}.nc",
                    study={"name": name, "kind": kind, "settings": chosen},
                    names={
                        "scene": scene,
                        "method": method,
                        "seed": int(seed) if seed.isdigit() else None,
                    },
                    case=self.case(scene, kind),
                    structure=self.at(scene, "structure"),
                    full_order=known,
                    fitted=[self.at(scene, need, model) for model in fitted for need in own],
                )

    def case(self, scene: str, kind: str) -> dict:
        """What a study knows besides artefacts."""
        case = {"scene": self.settings.scenes[scene].to_builtins()}
        if kind != "scene":
            case["integrator"] = self.settings.integrator
        if kind == "models":
            case |= {"methods": {}, "seed": self.settings.seeds[0], "device": "cpu"}
            for method, file in self.settings.methods.items():
                block = file.to_builtins()
                case["methods"][method] = {
                    "kind": self.settings.kind_of(method),
                    "settings": block["settings"],
                    "seeded": block["seeded"],
                    "start": block.get("starts_from"),
                }
        return case


# The forced runs and response curves that blow up: one seed of two, and a model's only run.
FAILED = {("large", "split", 1), ("large", "modal_projection", None)}
FAILED_AT = 0.011  # s


def failed(answer):
    """A forced run or a response curve that diverged, at its middle frequencies."""
    answer = answer.copy(deep=True)
    if answer["outcome"].ndim:
        lost = np.abs(np.arange(answer.sizes["angular_frequency"]) - 4) < 2
        answer["outcome"] = answer["outcome"].copy(data=np.where(lost, "diverged", "ok"))
        answer["failed_at"] = answer["failed_at"].where(~lost, 0.005)
        return answer.assign({name: answer[name].where(~lost) for name in ("amplitude", "phase")})
    answer["outcome"] = answer["outcome"].copy(data="diverged")
    answer["failed_at"] = answer["failed_at"].copy(data=FAILED_AT)
    answer["probe_displacement"] = answer["probe_displacement"].where(answer["time"] < FAILED_AT)
    answer["final_shape"] = answer["final_shape"] * np.nan
    return answer.assign(score_value=answer["score_value"] * np.nan)


def altered(collection: Collection, changes) -> Collection:
    """The same with `changes`, key -> what becomes of the dataset; None: it is not there."""
    loaders = dict(collection.loaders)
    for key, change in changes.items():
        old = loaders.pop(Key(*key), None)
        if change is not None:
            loaders[Key(*key)] = lambda old=old, change=change: change(old and old())
    return Collection(loaders)
