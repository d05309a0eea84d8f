"""Scenes, methods and studies: read, laid over, checked against what their plugs declare."""

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from vibrom.config import files, plugs, recorded
from vibrom.config.check import checked
from vibrom.config.digest import digest
from vibrom.config.errors import SettingsError
from vibrom.config.layers import Layers, Sources
from vibrom.config.method_file import MethodFile
from vibrom.config.recorded import RecordedScene
from vibrom.config.scene import Block, Scene, shape_of
from vibrom.config.sweeps import check_sweeps

MOST_STEPS = 10_000_000  # of one run of the full order
SCHEMES = "solvers/full/schemes"


def block(layers: Layers, path: tuple, kind: type[Block], without: str = "") -> dict[str, Any]:
    """The block at `path`, checked; one key of it may be another's business."""
    given: Any = layers.content
    for key in path:
        given = given.get(key, {})
    own = {key: value for key, value in given.items() if key != without}
    return checked(own, kind, path, layers.refuse)


def needed(experiments: Iterable[str], studies: Iterable[str]) -> set[str]:
    """The experiments of a run with those that they, or its studies, read or compare with."""
    known, found = plugs.names("experiments"), set()
    todo = [*experiments]
    for study in set(studies) & set(plugs.names("studies")):
        todo += plugs.constants("studies", study).get("experiments", ())
    while todo:
        name = todo.pop()
        if name in known and name not in found:
            found.add(name)
            constants = plugs.constants("experiments", name)
            todo += [*constants.get("reads", ()), str(constants.get("truth"))]
    return found


def scene(sources: Sources, folder: Path, name: str, asked: Iterable[str]) -> Scene | RecordedScene:
    """A scene's file with what is laid over it; `asked` are the experiments that it sets."""
    file = folder / "scenes" / f"{name}.yaml"
    own = files.read(file)
    layers = Layers(own, (file, ()))
    sources.lay_over(layers, "scene_settings", name)
    given = layers.content
    if "name" in given:
        layers.refuse(("name",), given["name"], "is that of the file; remove it")
    if "kind" in own:
        return _recorded(layers, own, name)
    kind = plugs.declared("vibrom.config.scene", "Scene")
    plain = checked({**given, "name": name}, kind, (), layers.refuse)
    shape = shape_of(given["body"])
    layers.check_known(("body", "shape"), shape, plugs.names("bodies"), "body")
    body = block(layers, ("body",), plugs.settings_of("bodies", shape), without="shape")
    if "mesh" in body:
        body |= _beside(layers, file.parent, ("body", "mesh"), body["mesh"])
    plain["body"] = {"shape": shape, **body}
    for key in ("clamped", "probes"):
        if key in body and not body[key]:
            layers.refuse(("body", key), body[key], "is empty; name at least one")
    plain["effects"] = _effects(layers, file.parent)
    plain["experiments"] = _experiments(layers, set(asked))
    _check_scene(plain, layers)
    return Scene.from_builtins(plain)


def _recorded(layers: Layers, own: dict[str, Any], name: str) -> RecordedScene:
    """A scene of files; what is laid over all scenes may be meant for those with a body."""
    layers.check_known(("kind",), own["kind"], [recorded.KIND], "kind of scene")
    for key in set(recorded.OF_BODIES) & set(layers.content) - set(own):
        del layers.content[key]
    kind = plugs.declared("vibrom.config.recorded", "RecordedScene")
    plain = checked({**layers.content, "name": name}, kind, (), layers.refuse)
    for path, file in recorded.files_of(plain).items():
        if not Path(file).is_file():
            layers.refuse(path, file, f"is no file, looked for in {Path.cwd()}; correct it")
    roles = [item["role"] for item in plain["recordings"]]
    for role in ("train", "test"):
        if role not in roles:
            cure = f"has no recording with the role {role}; give one, or split one by begin and end"
            layers.refuse(("recordings",), None, cure)
    for place, item in enumerate(plain["recordings"]):
        under, signal = item["role"] in recorded.UNDER_A_SIGNAL, item.get("signal")
        if under != bool(signal):
            cure = f"a recording with the role {item['role']} "
            cure += "needs the `signal` that drove it" if under else "is left alone; remove it"
            layers.refuse(("recordings", place, "signal"), signal, cure)
    made = _experiments(layers, set())
    # What reads the answer to another one goes without where that is not asked.
    plain["experiments"] = {key: made[key] for key in made if needed([key], ()) <= set(made)}
    return RecordedScene.from_builtins(plain)


def _beside(layers: Layers, folder: Path, key: tuple, name: str) -> dict[str, str]:
    """Where a file lies that a scene names, and the digest of what it holds: another file is
    another scene.
    """
    path = folder / name
    try:
        found = digest(path)
    except OSError as error:
        cure = f"cannot be read ({error.strerror}); put the file beside the scene's, in {folder}"
        layers.refuse(key, name, cure)
    return {key[-1]: str(path), "digest": found}


def _effects(layers: Layers, folder: Path) -> dict[str, Any]:
    """In the order in which they add up."""
    given = layers.content["effects"]
    if not given:
        layers.refuse(("effects",), given, "is empty, and nothing moves without; list some")
    for name in given:
        layers.check_known(("effects", name), name, plugs.names("effects"), "effect")
    return {name: _effect(layers, folder, name, given[name]) for name in plugs.in_order(given)}


def _effect(layers: Layers, folder: Path, name: str, given: Any) -> Any:
    """The settings of an effect, or a list of them."""
    path = "effects", name
    if not isinstance(given, list):
        return _acting(layers, folder, path, given)
    if not given:
        layers.refuse(path, given, "is empty; give settings, or leave the effect out")
    return [_acting(layers, folder, (*path, place), one) for place, one in enumerate(given)]


def _acting(layers: Layers, folder: Path, path: tuple, given: Any) -> dict[str, Any]:
    """The settings of an effect that acts once."""
    made = checked(given, plugs.settings_of("effects", path[1]), path, layers.refuse)
    if file := (made.get("signal") or {}).get("file"):
        file |= _beside(layers, folder, (*path, "signal", "file", "path"), file["path"])
    return made


def _experiments(layers: Layers, asked: set[str]) -> dict[str, dict[str, Any]]:
    """Settings of every experiment that the scene sets, that is asked, or that needs none; of one
    that runs `where_set` only what the scene sets.
    """
    given, known = layers.content.get("experiments", {}), plugs.names("experiments")
    for name in given:
        layers.check_known(("experiments", name), name, known, "experiment")
    made = {}
    for name in known:
        kind = plugs.settings_of("experiments", name)
        chosen = plugs.constants("experiments", name)["where_set"]
        everywhere = not chosen and (name in asked or not plugs.must_be_given(kind))
        if name in given or everywhere:
            made[name] = block(layers, ("experiments", name), kind)
    return made


def _check_scene(plain: dict[str, Any], layers: Layers) -> None:
    """What no single entry says."""
    for role, release in plain["releases"].items():
        _check_release(release, ("releases", role), layers)
    train, test = plain["releases"]["train"], plain["releases"]["test"]
    if train == test:
        cure = "is the training state; give another forcing, step or sweep"
        layers.refuse(("releases", "test"), test, cure)
    time = plain["time"]
    if time["steps_per_period"] % time["every"]:
        cure = f"does not divide steps_per_period = {time['steps_per_period']}; choose a divisor"
        layers.refuse(("time", "every"), time["every"], cure)
    runs: dict[tuple[str, ...], int] = {("record", "periods"): plain["record"]["periods"]}
    for name, settings in plain["experiments"].items():
        if isinstance(settings.get("periods"), int):
            runs["experiments", name, "periods"] = settings["periods"]
    for path, periods in runs.items():
        if (steps := periods * time["steps_per_period"]) > MOST_STEPS:
            cure = f"makes {steps:.3g} time steps; lower it, or time.steps_per_period"
            layers.refuse(path, periods, f"{cure} ({MOST_STEPS:.0e} at most)")
    if time["alpha"] and not plugs.constants(SCHEMES, time["scheme"]).get("DAMPED", True):
        cure = f"is damped, and time.scheme = {time['scheme']!r} has no damping; set it to zero"
        layers.refuse(("time", "alpha"), time["alpha"], cure)


def _check_release(release: dict[str, Any], path: tuple, layers: Layers) -> None:
    """A displacement, a velocity, or both."""

    def one(block: dict[str, Any], where: tuple, *names: str) -> None:
        given = [name for name in names if block[name]]
        if len(given) != 1:
            listed = f"{', '.join(names[:-1])} and {names[-1]}"
            cure = f"gives {' and '.join(given) or 'none'} of {listed}; give one"
            layers.refuse(where, block, cure)

    if release["velocity"]:
        one(release["velocity"], (*path, "velocity"), "direction", "mode")
    if release["forcing"] or not release["velocity"]:
        one(release, path, "step", "sweep", "static")
        if not release["forcing"]:
            cure = "is missing; add it (amplitude, as a multiple of the load)"
            layers.refuse((*path, "forcing"), None, cure)
    elif given := [name for name in ("step", "sweep", "static") if release[name]]:
        cure = f"is missing, and {given[0]} needs it; add it"
        layers.refuse((*path, "forcing"), None, cure)


def method(sources: Sources, folder: Path, name: str) -> MethodFile:
    """A method's file with the settings that are laid over its own, complete."""
    file = folder / "methods" / f"{name}.yaml"
    whole = Layers(files.read(file), (file, ()))
    kind = plugs.declared("vibrom.config.method_file", "MethodFile")
    plain = checked(whole.content, kind, (), whole.refuse)
    layers = Layers(whole.content.get("settings", {}), (file, ("settings",)))
    sources.lay_over(layers, "method_settings", name)
    if plain["rule"] is not None:  # an outside method knows its own settings
        for key, needed in (("method", False), ("rom_class", True)):
            if needed and plain[key] is None:
                whole.refuse((key,), None, "is missing; `rule` needs it, add it")
            if not needed and plain[key] is not None:
                cure = "has no use beside `rule`, which fits the model; remove one of them"
                whole.refuse((key,), plain[key], cure)
        settings = checked(layers.content, dict[str, Any], (), layers.refuse)
        return MethodFile.from_builtins(plain | {"settings": settings})
    known = plugs.names("methods")
    if plain["method"] is not None:
        whole.check_known(("method",), plain["method"], known, "file of src/vibrom/methods")
    elif name not in known:
        cure = (
            f"belongs to no src/vibrom/methods/{name}.py; write that file, name the `method` of "
            "which it is a variant, or give the `rule` of an outside method"
        )
        whole.refuse((), None, cure)
    chosen = plain["method"] or name
    settings = block(layers, (), plugs.settings_of("methods", chosen))
    return MethodFile.from_builtins(plain | {"method": chosen, "settings": settings})


def check_starts(methods: dict[str, MethodFile], folder: Path) -> None:
    """A method's start is in the run, and is fitted no more often than the method."""
    for name, given in methods.items():
        start, file = given.starts_from, folder / "methods" / f"{name}.yaml"
        if start is not None and (start not in methods or start == name):
            cure = f"is not among the methods of this run; add it to methods, or leave {name} out"
            raise SettingsError(file, "starts_from", start, cure)
        if start is not None and methods[start].seeded and not given.seeded:
            cure = f"but its start {start} is trained from seeds; set it to true"
            raise SettingsError(file, "seeded", False, cure)


def study(
    layers: Layers,
    name: str,
    folder: Path,
    scenes: Mapping[str, Scene | RecordedScene],
    methods: dict[str, MethodFile],
) -> dict[str, Any]:
    """The settings of a study, for those of its scenes that run; it needs scenes with a body."""
    layers.check_known(("studies", name), name, plugs.names("studies"), "study")
    made = block(layers, ("studies", name), plugs.settings_of("studies", name))
    known, chosen = stems(folder, "scenes"), made["scenes"]
    for place, scene in enumerate(chosen or ()):
        layers.check_known(("studies", name, "scenes", place), scene, known, "scene")
    bodies = [scene for scene, given in scenes.items() if isinstance(given, Scene)]
    made["scenes"] = [scene for scene in bodies if chosen is None or scene in chosen]
    if "reduced" in made:
        path, known = ("studies", name, "reduced"), stems(folder, "methods")
        for method in made["reduced"]:
            layers.check_known((*path, method), method, known, "method")
        made["reduced"] = check_sweeps(made["reduced"], methods, path, layers)
    return made


def stems(folder: Path, kind: str) -> list[str]:
    """The names of the files in config/scenes or config/methods."""
    return sorted(path.stem for path in (folder / kind).glob("*.yaml"))
