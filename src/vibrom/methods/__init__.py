"""One file a method: a frozen dataclass of its settings whose `fit(training)` gives the Rom."""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from typing import Any

from vibrom.config.instance import instance, plug
from vibrom.models.method import Method
from vibrom.models.training import MethodError


def method_from_settings(name: str, settings: Mapping[str, Any]) -> Method:
    """The one method of `vibrom.methods.<name>`, with these settings."""
    kind = plug(importlib.import_module(f"vibrom.methods.{name}"), "fit", MethodError)
    return instance(kind, settings, f"methods.{name}", MethodError)
