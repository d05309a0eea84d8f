"""An object of a plug's class from plain settings, checked by the same declaration as a file's."""

import dataclasses
from collections.abc import Mapping
from types import ModuleType
from typing import Any, TypeVar

import msgspec

from vibrom.config.errors import closest

Kind = TypeVar("Kind")


def plug(module: ModuleType, method: str, error: type[Exception]) -> type:
    """The one class with this method that the module defines."""
    found = [
        item
        for item in vars(module).values()
        if isinstance(item, type) and item.__module__ == module.__name__ and hasattr(item, method)
    ]
    if len(found) != 1:
        folder, name = module.__name__.split(".")[-2:]
        raise error(
            f"{folder}/{name}.py defines {len(found)} classes with a `{method}`; define exactly one"
        )
    return found[0]


def instance(
    kind: type[Kind], settings: Mapping[str, Any], where: str, error: type[Exception]
) -> Kind:
    """The object; raises `error` with one line that names the entry of the scene."""
    known = [field.name for field in dataclasses.fields(kind)]  # type: ignore[arg-type]
    if unknown := [key for key in settings if key not in known]:
        raise error(f"{where}.{unknown[0]} is no setting; {closest(unknown[0], known)}")
    try:
        # Numbers of numpy become plain ones.
        plain = msgspec.to_builtins(dict(settings), enc_hook=lambda number: number.tolist())
        return msgspec.convert(plain, kind)
    except msgspec.ValidationError as wrong:
        raise error(f"{where}: {wrong}; change it") from wrong
