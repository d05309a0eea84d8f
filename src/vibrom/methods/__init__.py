"""One file a method: a frozen dataclass of its settings whose `fit(training)` gives the Rom."""

from __future__ import annotations

import dataclasses
import importlib
from typing import Any

from vibrom.models.method import Method
from vibrom.models.training import MethodError


def method_from_settings(name: str, settings: dict[str, Any]) -> Method:
    """The one Method of `vibrom.methods.<name>`, with these settings."""
    module = importlib.import_module(f"vibrom.methods.{name}")
    found = [
        item
        for item in vars(module).values()
        if isinstance(item, type)
        and issubclass(item, Method)
        and item.__module__ == module.__name__
    ]
    if len(found) != 1:
        raise MethodError(
            f"methods/{name}.py defines {len(found)} methods; define exactly one subclass of Method"
        )
    known = {item.name for item in dataclasses.fields(found[0])}
    if unknown := sorted(set(settings) - known):
        raise MethodError(
            f"methods.{name}.{unknown[0]} = {settings[unknown[0]]!r} is unknown; "
            f"known settings: {', '.join(sorted(known))}"
        )
    return found[0](**settings)
