"""Checks a value against the kind of its setting and completes it with the defaults.

What comes out is plain and of one form: 100 and 100.0 are the same number, keys stand in the order
of their declaration or of the alphabet, lists are lists. The first wrong entry ends the check.
"""

import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NoReturn

import msgspec
from msgspec import inspect

from vibrom.config import plugs
from vibrom.config.errors import SettingsError, closest
from vibrom.config.kinds import FORMS
from vibrom.config.renamed import new_name

LARGEST = 1e60  # of a number in SI units: its fourth power, and that of its inverse, are finite
BOUNDS = {"ge": "at least", "gt": "greater than", "le": "at most", "lt": "less than"}
# What other readers take for a number: octal or hexadecimal, in sixties, or with underscores.
ALMOST = re.compile(r"[-+]?(0[0-9xob]|[0-9]+[_:])[0-9a-fA-F_:.]*([eE][-+]?[0-9]+)?")


@dataclass(frozen=True)
class Entry:
    """A value of the configuration and where it stands."""

    value: Any
    path: tuple
    refuse: Callable[[tuple, Any, str], NoReturn]  # path, value and cure -> the error
    about: str = ""  # unit and meaning

    def below(self, key: Any, about: str = "") -> "Entry":
        """The entry at a key or place of this one."""
        return Entry(self.value[key], (*self.path, key), self.refuse, about)

    def wrong(self, cure: str) -> NoReturn:
        """Refuse the value."""
        self.refuse(self.path, self.value, cure)

    def must_be(self, wanted: str, hint: str = "change it") -> NoReturn:
        """Refuse the value and say what is wanted, with what is known of the setting."""
        empty = "is empty and " if self.value is None else ""
        self.wrong(f"{empty}must be {wanted}; {hint}" + (f" ({self.about})" if self.about else ""))


def checked(value: Any, kind: Any, path: tuple, refuse: Callable[..., NoReturn]) -> Any:
    """`value` in plain form, if it is of this kind (a word of `kinds`, or the class of a block)."""
    return _checked(Entry(value, path, refuse), inspect.type_info(kind))


def _checked(entry: Entry, kind: inspect.Type) -> Any:
    match kind:
        case inspect.Metadata():
            return _described(entry, kind)
        case inspect.StructType():
            return _block(entry, kind)
        case inspect.DictType():
            return _mapping(entry, kind)
        case inspect.ListType() | inspect.VarTupleType() | inspect.TupleType():
            return _list(entry, kind)
        case inspect.IntType() | inspect.FloatType():
            return _number(entry, kind)
        case inspect.StrType():
            return _text(entry, kind)
        case inspect.BoolType():
            return entry.value if isinstance(entry.value, bool) else entry.must_be("true or false")
        case inspect.LiteralType():
            if not isinstance(entry.value, str) or entry.value not in kind.values:
                entry.wrong(f"is not known; {closest(entry.value, map(str, kind.values))}")
            return entry.value
        case inspect.UnionType():
            return _one_of(entry, kind)
        case inspect.AnyType():
            return _anything(entry)
    raise TypeError(f"{kind} is no kind of setting")


def _described(entry: Entry, kind: inspect.Metadata) -> Any:
    extra = kind.extra_json_schema or {}
    about = extra.get("description", entry.about)
    made = _checked(Entry(entry.value, entry.path, entry.refuse, about), kind.type)
    folder = (kind.extra or {}).get("plugs")
    if folder and made not in (known := plugs.names(folder)):
        entry.wrong(f"is not known; {closest(made, known)}")
    if folder := (kind.extra or {}).get("settings"):
        made = _settings(entry, folder, made)
    if extra.get("uniqueItems"):
        double = next((item for place, item in enumerate(made) if item in made[:place]), None)
        if double is not None:
            entry.wrong(f"repeats {double!r}; give each once")
    return made


def _settings(entry: Entry, folder: str, made: dict[str, Any]) -> dict[str, Any]:
    """Those of plugs of a folder, by name."""
    known, found = plugs.names(folder), {}
    for name in made:
        if name not in known:
            entry.below(name).wrong(f"is not known; {closest(name, known)}")
        found[name] = _checked(
            entry.below(name), inspect.type_info(plugs.settings_of(folder, name))
        )
    return found


def _block(entry: Entry, kind: inspect.StructType) -> dict[str, Any]:
    if not isinstance(entry.value, dict):
        entry.must_be("a block of `key: value` pairs")
    fields = {field.name: field for field in kind.fields}
    # A misspelt key comes first: it explains the missing one.
    for key in entry.value:
        if key not in fields:
            new = new_name(kind.cls.__name__, key, fields)
            cure = (
                f"is now {new}; move it there" if new else f"is no setting; {closest(key, fields)}"
            )
            entry.below(key).wrong(cure)
    made = {}
    for name, field in fields.items():
        if name in entry.value:
            made[name] = _checked(entry.below(name), field.type)
        else:
            made[name] = _default(entry, field)
    if {"lowest", "highest"} <= set(made) and made["lowest"] >= made["highest"]:
        where = Entry(made["lowest"], (*entry.path, "lowest"), entry.refuse)
        where.wrong(f"is not below highest = {made['highest']:g}; swap them")
    return made


def _default(entry: Entry, field: inspect.Field) -> Any:
    if field.required:
        about = (getattr(field.type, "extra_json_schema", None) or {}).get("description")
        cure = "is missing; add it" + (f" ({about})" if about else "")
        entry.refuse((*entry.path, field.name), None, cure)
    plain = msgspec.to_builtins(field.default_factory())  # as `plugs` declares all of them
    return _checked(Entry(plain, (*entry.path, field.name), entry.refuse), field.type)


def _mapping(entry: Entry, kind: inspect.DictType) -> dict[str, Any]:
    if not isinstance(entry.value, dict):
        entry.must_be("a block of `key: value` pairs")
    made = {}
    for key in entry.value:
        name = _checked(Entry(key, (*entry.path, key), entry.refuse), kind.key_type)
        made[name] = _checked(entry.below(key), kind.value_type)
    if isinstance(kind.key_type, inspect.LiteralType) and kind.min_length:
        for name in sorted(set(map(str, kind.key_type.values)) - set(made)):
            entry.refuse((*entry.path, name), None, "is missing; add it")
    _length(entry, kind, "entry", "entries")
    # The order of names means something: the first probe, the first guard.
    return made if getattr(kind.key_type, "pattern", None) else dict(sorted(made.items()))


def _list(entry: Entry, kind: Any) -> list[Any]:
    if not isinstance(entry.value, (list, tuple)):
        entry.must_be("a list")
    kinds = getattr(kind, "item_types", None)
    if kinds is None:
        _length(entry, kind, "entry", "entries")
        kinds = [kind.item_type] * len(entry.value)
    elif len(entry.value) != len(kinds):
        entry.must_be(f"a list of {len(kinds)}")
    return [_checked(entry.below(place, entry.about), item) for place, item in enumerate(kinds)]


def _length(entry: Entry, kind: Any, one: str, many: str) -> None:
    length, least, most = len(entry.value), kind.min_length or 0, kind.max_length or math.inf
    if not least <= length <= most:
        bound = least if length < least else most
        words = f"at {'least' if length < least else 'most'} {bound} {one if bound == 1 else many}"
        entry.must_be(f"{words} long")


def _number(entry: Entry, kind: inspect.IntType | inspect.FloatType) -> int | float:
    value, whole = entry.value, isinstance(kind, inspect.IntType)
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        almost = isinstance(value, str) and ALMOST.fullmatch(value)
        cure = "write it without leading zeros, colons or underscores" if almost else "change it"
        entry.must_be("a whole number" if whole else "a number", cure)
    _finite(entry)
    if whole and value != int(value):
        entry.must_be("a whole number")
    for bound, words in BOUNDS.items():
        limit = getattr(kind, bound)
        if limit is not None and not _holds(value, bound, limit):
            entry.must_be(f"{words} {limit:g}" if isinstance(limit, float) else f"{words} {limit}")
    if kind.multiple_of and value % kind.multiple_of:
        entry.must_be(f"a multiple of {kind.multiple_of}")
    return int(value) if whole else float(value)


def _finite(entry: Entry) -> None:
    value = entry.value
    if isinstance(value, float) and not math.isfinite(value):
        entry.wrong("is no finite number; give one")
    if abs(value) > LARGEST:
        entry.wrong(f"is too large a number; give one of at most {LARGEST:g}")
    if 0 < abs(value) < 1 / LARGEST:
        entry.wrong(f"is too small a number; give zero, or at least {1 / LARGEST:g}")


def _holds(value: float, bound: str, limit: float) -> bool:
    match bound:
        case "ge":
            return value >= limit
        case "gt":
            return value > limit
        case "le":
            return value <= limit
    return value < limit


def _text(entry: Entry, kind: inspect.StrType) -> str:
    if not isinstance(entry.value, str):
        scalar = isinstance(entry.value, (bool, int, float))
        entry.must_be("text", "put it in quotes" if scalar else "change it")
    if kind.pattern and not re.search(kind.pattern, entry.value):
        entry.must_be(FORMS.get(kind.pattern, f"of the form {kind.pattern}"))
    _length(entry, kind, "character", "characters")
    return entry.value


def _one_of(entry: Entry, kind: inspect.UnionType) -> Any:
    """The first of the kinds that the value is of; the error is that of the last."""
    if entry.value is None and any(isinstance(item, inspect.NoneType) for item in kind.types):
        return None
    kinds = [item for item in kind.types if not isinstance(item, inspect.NoneType)]
    for item in kinds[:-1]:
        try:
            return _checked(entry, item)
        except SettingsError:
            continue
    return _checked(entry, kinds[-1])


def _anything(entry: Entry) -> Any:
    """Numbers, text and what they are put together of, in plain form."""
    value = entry.value
    if isinstance(value, dict):
        return {key: _anything(entry.below(key)) for key in sorted(value)}
    if isinstance(value, (list, tuple)):
        return [_anything(entry.below(place)) for place in range(len(value))]
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        _finite(entry)
        return int(value) if float(value).is_integer() and abs(value) < 2**53 else float(value)
    return value
