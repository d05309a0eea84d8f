"""The configuration of a run: config.yaml, its overlays, the files of its scenes and methods,
merged and checked.

Every wrong input is one `SettingsError` of one line that names the file, the dotted key, the value
and the cure. Nothing numerical is imported.
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from vibrom.config import plugs
from vibrom.config.files import SettingsError, at, closest, merge, numbers, read, schema_errors

# Where an entry of a block stands: its path in the block -> the file, and the path in that file.
Place = Callable[[tuple], tuple[Path, tuple]]

FULL_ORDER = "full_order"
UNSEEDED = "unseeded"
# What the type of a dataclass field means for a value of the configuration.
# What the study of costs varies besides the settings of a method: see vibrom.steps.cost_reduced.
STUDIED = {"thin": "int", "periods": "int", "rtol": "float"}
TYPES = {"float": (int, float), "int": (int,), "str": (str,), "bool": (bool,)}


@dataclass(frozen=True)
class Settings:
    """A checked configuration. Scenes and methods are complete: files and overlays merged."""

    results: str
    scenes: dict[str, dict[str, Any]]
    methods: dict[str, dict[str, Any]]
    seeds: list[int]
    experiments: list[str]
    integrator: dict[str, float]
    effects: dict[str, int]
    device: str
    cost: dict[str, Any]
    stability: dict[str, Any]

    def seed_folders(self, method: str) -> list[str]:
        """`seed_0`, `seed_1`, ..., or `unseeded` for a method that is fitted once."""
        return (
            [f"seed_{seed}" for seed in self.seeds]
            if self.methods[method]["seeded"]
            else [UNSEEDED]
        )

    def kind_of(self, method: str) -> str:
        """The file of src/vibrom/methods behind a method: the one that a variant names, else that
        of its own name.
        """
        return self.methods[method].get("method", method)

    def start_of(self, method: str, folder: str) -> tuple[str, str] | None:
        """Method and seed folder of the model that this one starts from."""
        start = self.methods[method].get("starts_from")
        return (
            None
            if start is None
            else (start, folder if self.methods[start]["seeded"] else UNSEEDED)
        )


def load(config: dict[str, Any], *, folder: Path, schemas: Path, files: list[str] = ()) -> Settings:
    """The settings of a run: `config` is config.yaml of `folder` with `files` laid over it."""
    return Reader(config, folder, schemas, [Path(name) for name in files]).settings()


class Reader:
    """Reads and checks; a complaint names the last file that has the entry."""

    def __init__(self, config: dict[str, Any], folder: Path, schemas: Path, files: list[Path]):
        self.config, self.folder, self.schemas = numbers(config), folder, schemas
        self.main = folder / "config.yaml"
        self.files = [(path, read(path)) for path in (self.main, *files) if path.is_file()]

    def settings(self) -> Settings:
        schema_errors(
            self.config,
            self.schemas / "config.schema.yaml",
            lambda path: (self.file_of(*path), path),
        )
        self.check_known("experiments", plugs.names("experiments"))
        for kind, extra in (("scene", ["all"]), ("method", [])):
            self.check_known(f"{kind}s", self.stems(f"{kind}s"))
            self.check_known(f"{kind}_settings", self.stems(f"{kind}s") + extra)
        scenes = {name: self.scene(name) for name in self.config["scenes"]}
        methods = {name: self.method(name) for name in self.config["methods"]}
        check_starts(methods, self.folder)
        self.check_cost(methods)
        plain = {
            name: self.config[name]
            for name in (
                "results",
                "seeds",
                "experiments",
                "integrator",
                "effects",
                "device",
                "cost",
            )
        }
        return Settings(scenes=scenes, methods=methods, **plain, stability=self.stability(scenes))

    def stability(self, scenes: dict[str, Any]) -> dict[str, Any]:
        """The grid of hard cases, for those of its scenes that run."""
        given = self.config.get("stability", {"scenes": []})
        known = self.stems("scenes")
        for index, name in enumerate(given["scenes"]):
            if name not in known:
                raise SettingsError(
                    self.file_of("stability", "scenes"),
                    ("stability", "scenes", index),
                    name,
                    f"is no scene; {closest(name, known)}",
                )
        return given | {"scenes": [name for name in given["scenes"] if name in scenes]}

    def file_of(self, *path: str | int) -> Path:
        """The last file that holds this entry of the configuration."""
        return next(
            (file for file, content in reversed(self.files) if at(content, path) is not None),
            self.main,
        )

    def stems(self, kind: str) -> list[str]:
        return sorted(path.stem for path in (self.folder / kind).glob("*.yaml"))

    def check_known(self, key: str, known: list[str]) -> None:
        """Every name under `key` of the configuration is one of these."""
        what = (
            key.removesuffix("s")
            if key in ("scenes", "methods", "experiments")
            else key.removesuffix("_settings")
        )
        for index, name in enumerate(self.config.get(key, [])):
            if name not in known:
                where = (key, index) if isinstance(self.config[key], list) else (key,)
                raise SettingsError(
                    self.file_of(key), where, name, f"is no {what}; {closest(name, known)}"
                )

    def scene(self, name: str) -> dict[str, Any]:
        layers = {
            ("scene_settings", who): at(self.config, ("scene_settings", who)) or {}
            for who in ("all", name)
        }
        scene, place = self.block("scenes", name, layers, depth=0)
        check_scene(scene, place)
        return scene

    def method(self, name: str) -> dict[str, Any]:
        layers = {
            ("method_settings", name): {
                "settings": at(self.config, ("method_settings", name)) or {}
            }
        }
        method, place = self.block("methods", name, layers, depth=1)
        check_method(name, method, place)
        return method

    def check_cost(self, methods: dict[str, dict[str, Any]]) -> None:
        """Scenes and methods of the study are known, and the settings that it varies are those of
        the method.
        """
        for index, name in enumerate(self.config["cost"]["scenes"]):
            if name not in (known := self.stems("scenes")):
                path = ("cost", "scenes", index)
                raise SettingsError(
                    self.file_of(*path), path, name, f"is no scene; {closest(name, known)}"
                )
        for name, blocks in self.config["cost"]["reduced"].items():
            path = ("cost", "reduced", name)
            if name not in (known := self.stems("methods")):
                raise SettingsError(
                    self.file_of(*path), path, blocks, f"is no method; {closest(name, known)}"
                )
            for index, block in enumerate(blocks if name in methods else ()):
                for key in block["vary"]:
                    self.check_varied(methods, name, key, block["over"], (*path, index))

    def check_varied(
        self, methods: dict[str, dict[str, Any]], name: str, key: str, values: list, path: tuple
    ) -> None:
        """A setting that the study varies: of the method, of the one that it starts from, or one of
        the study's own (`STUDIED`).
        """
        start = methods[name].get("starts_from")
        which, own = (
            (start, key.removeprefix("start."))
            if key.startswith("start.") and start
            else (name, key)
        )
        outside = "rule" in methods[which]
        known = (
            {}
            if outside
            else {
                field: entry.annotation
                for field, entry in plugs.settings_of(
                    "methods", methods[which].get("method", which)
                ).items()
            }
        )
        known |= {"rtol": "float"} if outside else STUDIED if which == name else {}
        if own not in known:
            raise SettingsError(
                self.file_of(*path),
                (*path, "vary"),
                key,
                f"is no setting of {which}; {closest(own, list(known))}",
            )
        wanted = TYPES.get(known[own])
        for value in values:
            if wanted and (
                not isinstance(value, wanted)
                or isinstance(value, bool)
                and bool not in wanted
                or own in STUDIED
                and value <= 0
            ):
                raise SettingsError(
                    self.file_of(*path),
                    (*path, "over"),
                    value,
                    f"must be a value of {key}, of type {known[own]}; write such a value",
                )

    def block(
        self, kind: str, name: str, layers: dict[tuple, dict], depth: int
    ) -> tuple[dict[str, Any], Place]:
        """A scene or method: its file with `layers` of the configuration on it, which start `depth`
        keys below.
        """
        file = self.folder / kind / f"{name}.yaml"
        content = numbers(read(file))
        for layer in layers.values():
            content = merge(content, layer)

        def place(path: tuple) -> tuple[Path, tuple]:
            for where, layer in reversed(layers.items()):
                if at(layer, path) is not None:
                    return self.file_of(*where), (*where, *path[depth:])
            return file, path

        schema_errors(content, self.schemas / f"{kind.removesuffix('s')}.schema.yaml", place)
        return content, place


def check_plug(folder: str, name: str, given: dict[str, Any], place: Place, path: tuple) -> None:
    """Every setting is a field of the plug, of its type, and none is missing."""
    fields = plugs.settings_of(folder, name)
    for key, value in given.items():
        file, where = place((*path, key))
        if key not in fields:
            raise SettingsError(
                file, where, value, f"is no setting of {name}; {closest(key, list(fields))}"
            )
        wanted = TYPES.get(fields[key].annotation)
        if wanted and (
            not isinstance(value, wanted) or isinstance(value, bool) and bool not in wanted
        ):
            raise SettingsError(
                file, where, value, f"must be of type {fields[key].annotation}; write such a value"
            )
    for key, entry in fields.items():
        if entry.required and key not in given:
            file, where = place(path)
            raise SettingsError(file, (*where, key), None, f"is missing; {name} needs it, add it")


def check_scene(scene: dict[str, Any], place: Place) -> None:
    """What the schema of a scene cannot say."""
    known = plugs.names("effects")
    for effect, given in scene["effects"].items():
        if effect not in known:
            file, where = place(("effects", effect))
            raise SettingsError(file, where, given, f"is no effect; {closest(effect, known)}")
        scene["effects"][effect] = given or {}
        check_plug("effects", effect, given or {}, place, ("effects", effect))
        if "at" in (given or {}):  # a key of this name is a point of the body
            check_probe(scene["body"], given["at"], place(("effects", effect, "at")))
    body, time = scene["body"], scene["time"]
    for probe, where_at in body["probes"].items():
        check_probe(body, where_at["at"], place(("body", "probes", probe, "at")))
    if scene["releases"]["train"] == scene["releases"]["test"]:
        file, where = place(("releases", "test"))
        raise SettingsError(
            file,
            where,
            scene["releases"]["test"],
            "is the training state; give another forcing or step",
        )
    if time["steps_per_period"] % time["every"]:
        file, where = place(("time", "every"))
        raise SettingsError(
            file,
            where,
            time["every"],
            f"does not divide steps_per_period = {time['steps_per_period']}; choose a divisor of it",
        )
    if scene["frc"]["from"] >= scene["frc"]["to"] and scene["frc"]["frequencies"] > 1:
        file, where = place(("frc", "from"))
        raise SettingsError(
            file,
            where,
            scene["frc"]["from"],
            f"is not below frc.to = {scene['frc']['to']}; swap them",
        )


def check_probe(body: dict[str, Any], point: list[float], stands: tuple[Path, tuple]) -> None:
    """A probe, or where an effect acts, is a node that can move."""
    parts = 1 if body["element"] == "bilinear" else 2
    spacing = [
        size / (cells * parts)
        for size, cells in zip((body["length"], body["height"]), body["cells"], strict=True)
    ]
    nearest = [
        min(max(round(x / h), 0), cells * parts) * h
        for x, h, cells in zip(point, spacing, body["cells"], strict=True)
    ]
    if max(abs(x - y) for x, y in zip(point, nearest, strict=True)) > 1e-6:
        raise SettingsError(
            *stands,
            point,
            f"is no node of the mesh; the nearest one is {[float(f'{x:.9g}') for x in nearest]}",
        )
    edges = {
        "left": point[0] == 0,
        "right": point[0] == body["length"],
        "bottom": point[1] == 0,
        "top": point[1] == body["height"],
    }
    held = [edge for edge in body["clamped"] if edges[edge]]
    if held:
        raise SettingsError(
            *stands,
            point,
            f"lies on the clamped {held[0]} edge and cannot move; choose another node",
        )


def check_method(name: str, method: dict[str, Any], place: Place) -> None:
    """What the schema of a method cannot say."""
    method["settings"] = method["settings"] or {}
    known = plugs.names("methods")
    if "rule" in method:
        if "method" in method:
            raise SettingsError(
                *place(("method",)),
                method["method"],
                "has no use beside `rule`, which fits the model; remove one of them",
            )
        return  # an outside method reads its own settings
    if "method" in method:
        if method["method"] not in known:
            raise SettingsError(
                *place(("method",)),
                method["method"],
                f"is no file of src/vibrom/methods; {closest(method['method'], known)}",
            )
    elif name not in known:
        file, where = place(("settings",))
        cure = f"belongs to no src/vibrom/methods/{name}.py; write that file, name the `method` of which it is a variant, or give the `rule` of an outside method"
        raise SettingsError(file, where, method["settings"], cure)
    check_plug("methods", method.get("method", name), method["settings"], place, ("settings",))


def check_starts(methods: dict[str, dict[str, Any]], folder: Path) -> None:
    """A method's start is in the run, and is fitted no more often than the method."""
    for name, method in methods.items():
        start, file = method.get("starts_from"), str(folder / "methods" / f"{name}.yaml")
        if start is None:
            continue
        if start not in methods or start == name:
            raise SettingsError(
                file,
                ("starts_from",),
                start,
                f"is not among the methods of this run; add it to methods, or leave {name} out",
            )
        if methods[start]["seeded"] and not method["seeded"]:
            raise SettingsError(
                file,
                ("seeded",),
                False,
                f"but its start {start} is trained from seeds; set it to true",
            )
