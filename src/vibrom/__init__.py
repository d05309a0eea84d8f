"""Which reduced-order model predicts a structure that bends far, how well, and what that accuracy
costs in time.

`load`, `of_arrays`, `fit` and `open_model` are at hand as `vibrom.load`, ...: see `vibrom.api`.
"""

from importlib import import_module

__version__ = "0.2.0.dev0"

PUBLIC = ("load", "of_arrays", "fit", "open_model", "Recorded", "FittedModel")


def __getattr__(name: str):
    """The public names, loaded when they are first asked for: the workflow needs none of them."""
    if name not in PUBLIC:
        raise AttributeError(f"module 'vibrom' has no attribute {name!r}")
    return getattr(import_module("vibrom.api"), name)


def __dir__() -> list[str]:
    return [*globals(), *PUBLIC]
