"""A wrong entry of the configuration is one line: file, dotted key, value and cure."""

import difflib
from collections.abc import Iterable
from pathlib import Path
from typing import Any

LISTED = 240  # characters of a list of choices
LONGEST = 60  # of a key or value that is shown


class ConfigError(ValueError):
    """The configuration, or a plug that declares a part of it, cannot be used; one line."""


class SettingsError(ConfigError):
    """A wrong entry: in which file, at which key, what it holds, and what to do about it."""

    def __init__(self, file: str | Path, key: str | tuple, value: Any, cure: str):
        where = key if isinstance(key, str) else dotted(key)
        shown = "" if value is None else f" = {_short(value)}"
        super().__init__(_line(f"{_near(file)}: {where}{shown} {cure}"))


def dotted(path: tuple) -> str:
    """body.cells[0]"""
    steps = (f"[{key}]" if isinstance(key, int) else f".{_cut(key)}" for key in path)
    return "".join(steps).lstrip(".") or "file"


def closest(word: Any, known: Iterable[str]) -> str:
    """The cure for a word that is not known."""
    known = list(known)
    if near := difflib.get_close_matches(str(word), known, 1, 0.6):
        return f"did you mean {near[0]!r}?"
    return f"choose from {_listed(known)}" if known else "remove it"


def _listed(words: list[str]) -> str:
    """As many as fit one line; there may be hundreds of scenes."""
    ends = [len(", ".join(words[: count + 1])) for count in range(len(words))]
    shown = max(1, sum(end <= LISTED for end in ends))
    rest = len(words) - shown
    return ", ".join(words[:shown]) + (f" and {rest} more" if rest else "")


def _short(value: Any) -> str:
    return _cut(_line(repr(value)))


def _cut(text: str) -> str:
    return text if len(text) <= LONGEST else f"{text[: LONGEST - 3]}..."


def _line(text: str) -> str:
    """`text` on one line, control characters written out."""
    return "".join(c if c.isprintable() else repr(c)[1:-1] for c in " ".join(text.split()))


def _near(file: str | Path) -> str:
    """The file as seen from here, where it lies below."""
    path = Path(file)
    below = path.is_absolute() and path.is_relative_to(Path.cwd())
    return str(path.relative_to(Path.cwd()) if below else path)
