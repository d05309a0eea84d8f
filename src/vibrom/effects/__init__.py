"""One file an effect: a frozen dataclass of the scene's keys whose `assemble(space, base)` gives
the Term that it adds.

`base` is the sum of the effects listed before it. An effect that a scene does not list is never
imported.
"""

import importlib
from typing import Any

from vibrom.bodies.space import Space
from vibrom.term import SceneError, Term


def assemble(space: Space, effects: dict[str, dict[str, Any]]) -> Term:
    """The sum of the effects of a scene, in their order."""
    total = Term()
    for name, settings in effects.items():
        total = total + load(name, settings or {}).assemble(space, total)
    return total


def load(name: str, settings: dict[str, Any]) -> Any:
    """The effect of this name: the one class with an `assemble` that `effects/<name>.py` defines."""
    module = importlib.import_module(f"vibrom.effects.{name}")
    found = [
        item
        for item in vars(module).values()
        if isinstance(item, type)
        and item.__module__ == module.__name__
        and hasattr(item, "assemble")
    ]
    if len(found) != 1:
        raise SceneError(
            f"effects/{name}.py defines {len(found)} classes with an `assemble`; define exactly one"
        )
    return found[0](**settings)
