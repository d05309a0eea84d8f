"""Blocks laid over one another: mappings merge, lists and values replace, null removes.

Every entry remembers the file that gave it last, which an error then names.
"""

from collections.abc import Iterable, Mapping
from copy import deepcopy
from pathlib import Path
from typing import Any, NoReturn

from vibrom.config import files
from vibrom.config.errors import SettingsError, closest

# These stand for a file in an error about a value of the command line, or of another workflow.
COMMAND, MODULE = "--config", "config of the module"
ALL = "all"  # the scenes, in `scene_settings`
OVER_BLOCKS = ("scene_settings", "method_settings")
Origin = tuple[str | Path, tuple]  # a file, and the path of a block in it


class Layers:
    """`content` is what the layers add up to."""

    def __init__(self, content: Any, origin: Origin):
        self.content: dict[str, Any] = {}
        self.origin: dict[tuple, Origin] = {(): origin}
        self.removed: set[tuple] = set()  # what was here once: it may be removed again
        self.lay(content, origin)

    def lay(self, content: Any, origin: Origin, *, lenient: bool = False) -> None:
        """Lay a block on top; a lenient one may remove what is not there."""
        if not isinstance(content, dict):
            raise SettingsError(*origin, content, "must be a block of `key: value` pairs")
        self._merge(self.content, content, (), origin, lenient)

    def _merge(self, below: dict, above: dict, path: tuple, origin: Origin, lenient: bool) -> None:
        for key, value in above.items():
            here = (*path, key)
            if value is None and not (lenient or key in below or here in self.removed):
                cure = "is empty; give a value, or {} for a block without settings"
                if ":" in key:
                    cure = "is empty; put a blank behind the colon"
                raise SettingsError(origin[0], (*origin[1], *here), None, cure)
            if isinstance(value, dict) and isinstance(below.get(key), dict):
                self._merge(below[key], value, here, origin, lenient)
                continue
            if value is None and key in below:
                self.removed.update(_places(below[key], here))
            before = self.origin
            self.origin = {at: file for at, file in before.items() if at[: len(here)] != here}
            self.origin[here] = origin
            was = below.pop(key, None)
            if isinstance(value, dict):
                block: dict[str, Any] = {}
                self._merge(block, value, here, origin, lenient)
                if was is None and value and not block:  # what only removes brings nothing back
                    self.origin = before
                else:
                    below[key] = block
            elif value is not None:
                below[key] = deepcopy(value)

    def refuse(self, path: tuple, value: Any, cure: str) -> NoReturn:
        """The error for the entry at `path`, in the file that gave it."""
        known = next(path[:end] for end in range(len(path), -1, -1) if path[:end] in self.origin)
        file, under = self.origin[known]
        raise SettingsError(file, (*under, *path), value, cure)

    def check_known(self, path: tuple, name: str, known: Iterable[str], what: str) -> None:
        """Refuse the name that stands at `path`, or is its last key, unless it is known."""
        if name not in (known := list(known)):
            value: Any = name
            if path[-1] == name:
                value = self.content
                for key in path:
                    value = value[key]
            self.refuse(path, value, f"is no {what}; {closest(name, known)}")


class Sources:
    """config.yaml, the files laid over it, and the values of the command line, in this order; or of
    what else is the `origin` of such values.
    """

    def __init__(
        self, paths: Iterable[str | Path], command: Mapping[str, Any], origin: str = COMMAND
    ):
        self.blocks: list[tuple[str | Path, dict[str, Any]]] = [
            (path, files.read(Path(path))) for path in paths
        ]
        if command:
            if not isinstance(command, Mapping):
                cure = "must hold `key: value` pairs; give a block of the configuration"
                raise SettingsError(origin, "config", command, cure)
            self.blocks.append((origin, _words(dict(command))))

    def config(self) -> Layers:
        """All but what is laid over scenes and methods."""
        (path, main), *others = self.blocks
        layers = Layers(_without(main), (path, ()))
        for file, content in others:
            layers.lay(_without(content), (file, ()))
        return layers

    def check_names(self, key: str, known: Iterable[str]) -> None:
        """Refuse what is laid over a scene or method that does not exist."""
        known = [*known, ALL] if key == "scene_settings" else list(known)
        for file, content in self.blocks:
            given = content.get(key) or {}
            if not isinstance(given, dict):
                raise SettingsError(file, key, given, "must be a block of `key: value` pairs")
            for name in given:
                if name not in known:
                    cure = f"is no {key.removesuffix('_settings')}; {closest(name, known)}"
                    raise SettingsError(file, (key, name), given[name], cure)

    def lay_over(self, layers: Layers, key: str, name: str) -> None:
        """Lay on a scene or method what these say of it: of all scenes first, then of this one."""
        for who in (ALL, name):
            laid: list[tuple[Any, Origin]] = []
            for file, content in self.blocks:
                given = content.get(key, {})
                if given is None or given.get(who, {}) is None:
                    laid.clear()
                elif who in given:
                    laid.append((given[who], (file, (key, who))))
            for block, origin in laid:
                layers.lay(block, origin, lenient=who == ALL)


def _places(value: Any, path: tuple) -> list[tuple]:
    """The path of an entry, and of all that is in it."""
    inside = value.items() if isinstance(value, dict) else ()
    return [path, *(found for key, item in inside for found in _places(item, (*path, key)))]


def _without(content: dict[str, Any]) -> dict[str, Any]:
    return {key: block for key, block in content.items() if key not in OVER_BLOCKS}


def _words(value: Any) -> Any:
    """A value of the command line as Snakemake hands it on: its nested words are still text."""
    if isinstance(value, dict):
        return {str(key): _words(item) for key, item in value.items()}
    if isinstance(value, list):
        return [_words(item) for item in value]
    return files.plain(value) if isinstance(value, str) else value
