"""Reads YAML 1.2: a plain `on`, `no`, `1:30`, `0200` or date is text, and 1e-8 is a number.

PyYAML takes a file apart; what its plain words mean (YAML 1.2.2, section 10.2.2) is said here. Keys
are always text. Leading zeros, which other readers take for octal numbers, make text.
"""

import re
from pathlib import Path
from typing import Any, NoReturn

import yaml

from vibrom.config.errors import SettingsError

WORDS = {
    **dict.fromkeys(("", "~", "null", "Null", "NULL"), None),
    **dict.fromkeys(("true", "True", "TRUE"), True),
    **dict.fromkeys(("false", "False", "FALSE"), False),
}
WHOLE = re.compile(r"[-+]?(0|[1-9][0-9]*)")
NUMBER = re.compile(r"[-+]?((0|[1-9][0-9]*)(\.[0-9]*)?|\.[0-9]+)([eE][-+]?[0-9]+)?")
ENDLESS = re.compile(r"[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)")
DIGITS = 400  # of a whole number; no setting has more
ENTRIES, DEPTH = 100_000, 50  # of one file, its aliases written out


def read(path: Path) -> dict[str, Any]:
    """The mapping in a YAML file."""
    try:
        text = path.read_bytes().decode("utf-8-sig")
    except OSError as error:
        cure = f"cannot be read ({error.strerror}); check the name"
        raise SettingsError(path, "file", None, cure) from error
    except UnicodeDecodeError as error:
        raise SettingsError(path, "file", None, "is not UTF-8 text; save it as UTF-8") from error
    try:
        content = _Document(path, text).content()
    except yaml.YAMLError as error:
        mark, problem = getattr(error, "problem_mark", None), getattr(error, "problem", None)
        line = f"line {mark.line + 1}" if mark else "file"
        cure = f"is not YAML ({problem or 'unreadable text'}); correct it"
        raise SettingsError(path, line, None, cure) from error
    if not isinstance(content, dict):
        raise SettingsError(path, "file", None, "holds no `key: value` pairs; write some")
    return content


def plain(text: str) -> Any:
    """What an unquoted word is: nothing, true or false, a number, or text."""
    if text in WORDS:
        return WORDS[text]
    if WHOLE.fullmatch(text) and len(text) <= DIGITS:
        return int(text)
    if NUMBER.fullmatch(text):
        return float(text)
    return float(text.replace(".", "")) if ENDLESS.fullmatch(text) else text


class _Document:
    """One file, event by event; aliases share what they name, and count as if written out."""

    def __init__(self, path: Path, text: str):
        self.path, self.depth, self.entries = path, 0, 0
        self.events = yaml.parse(text, yaml.CLoader if yaml.__with_libyaml__ else yaml.Loader)
        # anchor -> (value, entries, depth), None while it is being read
        self.anchors: dict[str, tuple[Any, int, int] | None] = {}

    def content(self) -> Any:
        content = None
        for event in self.events:
            if isinstance(event, yaml.NodeEvent):
                content = self.value(event)
            elif isinstance(event, yaml.DocumentStartEvent) and content is not None:
                self.refuse(event, "begins a second document; leave one")
        return content

    def refuse(self, event: yaml.Event, cure: str) -> NoReturn:
        raise SettingsError(self.path, f"line {event.start_mark.line + 1}", None, cure)

    def value(self, event: yaml.NodeEvent) -> Any:
        """What begins with this event."""
        before = self.entries
        if isinstance(event, yaml.AliasEvent):
            known = self.anchors.get(event.anchor, ())
            if not known:
                lacks = "stands for nothing before it" if known == () else "holds itself"
                self.refuse(event, f"alias *{event.anchor} {lacks}; write it out")
            made, entries, depth = known
            self.count(event, entries, depth)
            return made
        self.count(event, 1, isinstance(event, yaml.CollectionStartEvent))
        if event.anchor:
            self.anchors[event.anchor] = None
        if event.tag not in (None, "!", "tag:yaml.org,2002:str"):
            self.refuse(event, f"has the tag {event.tag!r}, which means nothing here; remove it")
        if isinstance(event, yaml.ScalarEvent):
            made = plain(event.value) if not (event.style or event.tag) else event.value
        else:
            self.depth += 1
            made = self.mapping() if isinstance(event, yaml.MappingStartEvent) else self.sequence()
            self.depth -= 1
        if event.anchor:
            self.anchors[event.anchor] = made, self.entries - before, _depth(made)
        return made

    def count(self, event: yaml.Event, entries: int, depth: int) -> None:
        self.entries += entries
        if self.depth + depth > DEPTH:
            self.refuse(event, f"is nested more than {DEPTH} deep; nothing here needs that")
        if self.entries > ENTRIES:
            self.refuse(event, f"grows beyond {ENTRIES} entries through its aliases; use fewer")

    def sequence(self) -> list[Any]:
        items = []
        while not isinstance(event := next(self.events), yaml.SequenceEndEvent):
            items.append(self.value(event))
        return items

    def mapping(self) -> dict[str, Any]:
        """Its entries over those that `<<` merges into it, of which the first ones win."""
        own: dict[str, Any] = {}
        merged: list[dict[str, Any]] = []
        while not isinstance(key := next(self.events), yaml.MappingEndEvent):
            if not isinstance(key, yaml.ScalarEvent) or key.tag or key.anchor:
                self.refuse(key, "has a key that is no word; write one")
            value = self.value(next(self.events))
            if key.value == "<<" and not key.style:
                merged += value if isinstance(value, list) else [value]
                if not all(isinstance(block, dict) for block in merged):
                    self.refuse(key, "'<<' merges blocks only; name one")
            elif key.value in own:
                self.refuse(key, f"{key.value!r} is given twice; remove one")
            else:
                own[key.value] = value
        return {key: value for block in (*reversed(merged), own) for key, value in block.items()}


def _depth(value: Any) -> int:
    items = value.values() if isinstance(value, dict) else value if isinstance(value, list) else ()
    return 1 + max(map(_depth, items), default=0) if isinstance(value, (dict, list)) else 0
