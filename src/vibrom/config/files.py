"""Reading, merging and schema-checking of configuration files; each complaint is one line."""

import difflib
import math
import re
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import yaml

# YAML 1.1, which PyYAML reads, takes 1e-8 and 104.0e9 for text; YAML 1.2 and everyone else take
# them for numbers.
NUMBER = re.compile(r"[-+]?(\d+(\.\d*)?|\.\d+)[eE][-+]?\d+")


class SettingsError(ValueError):
    """A wrong entry of the configuration: which file, which key, what it holds, and what to do
    about it.
    """

    def __init__(self, file: str | Path, key: str | tuple, value: Any, cure: str):
        shown = "" if value is None else f" = {_short(value)}"
        super().__init__(
            f"{_near(file)}: {key if isinstance(key, str) else dotted(key)}{shown} {cure}"
        )


class _Loader(getattr(yaml, "CSafeLoader", yaml.SafeLoader)):
    """Refuses a key that is given twice: the second would silently win."""

    def construct_mapping(self, node, deep=False):
        seen = set()
        for key_node, _ in node.value:
            if key_node.tag == "tag:yaml.org,2002:merge":
                continue
            key = self.construct_object(key_node, deep=True)
            if key in seen:
                raise yaml.constructor.ConstructorError(
                    None, None, f"{key!r} is given twice; remove one", key_node.start_mark
                )
            seen.add(key)
        return super().construct_mapping(node, deep)


def read(path: Path) -> dict[str, Any]:
    """The mapping in a YAML file."""
    try:
        content = yaml.load(path.read_text(), _Loader)
    except OSError as error:
        raise SettingsError(
            str(path), "file", None, f"cannot be read ({error.strerror}); check the name"
        ) from error
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        mark = getattr(error, "problem_mark", None)
        line = f"line {mark.line + 1}" if mark else "file"
        raise SettingsError(
            str(path),
            line,
            None,
            f"is not YAML ({getattr(error, 'problem', None) or 'unreadable text'}); correct it",
        ) from error
    if not isinstance(content, dict):
        raise SettingsError(str(path), "file", None, "holds no `key: value` pairs; write some")
    return content


def numbers(value: Any) -> Any:
    """`value` with plain containers, and with numbers where YAML 1.1 sees text such as 1e-8."""
    if isinstance(value, dict):
        return {key: numbers(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [numbers(item) for item in value]
    return float(value) if isinstance(value, str) and NUMBER.fullmatch(value) else value


def merge(below: dict[str, Any], above: dict[str, Any]) -> dict[str, Any]:
    """`below` with the entries of `above` laid over it; mappings are merged, all else is replaced."""
    merged = dict(below)
    for key, value in above.items():
        old = merged.get(key)
        merged[key] = (
            merge(old, value) if isinstance(old, dict) and isinstance(value, dict) else value
        )
    return merged


def at(content: Any, path: tuple) -> Any:
    """The entry at `path`, or None."""
    for key in path:
        if isinstance(content, dict):
            content = content.get(key)
        elif isinstance(content, list) and isinstance(key, int) and key < len(content):
            content = content[key]
        else:
            return None
    return content


def dotted(path: tuple) -> str:
    """body.cells[0]"""
    return (
        "".join(f"[{key}]" if isinstance(key, int) else f".{key}" for key in path).lstrip(".")
        or "file"
    )


def closest(word: Any, known: list[str]) -> str:
    """The cure for a word that is not known."""
    near = difflib.get_close_matches(str(word), known, 1, 0.6)
    return (
        f"did you mean {near[0]!r}?"
        if near
        else f"choose from {', '.join(known)}"
        if known
        else "remove it"
    )


def _short(value: Any) -> str:
    text = " ".join(repr(value).split())
    return text if len(text) <= 60 else f"{text[:57]}..."


def _near(file: str | Path) -> str:
    """The file as seen from here, where it lies below."""
    path = Path(file)
    return (
        str(path.relative_to(Path.cwd()))
        if path.is_absolute() and path.is_relative_to(Path.cwd())
        else str(path)
    )


@cache
def _validator(path: Path):
    from jsonschema import Draft202012Validator

    return Draft202012Validator(yaml.load(path.read_text(), _Loader))


def schema_errors(
    content: dict[str, Any], schema: Path, place: Callable[[tuple], tuple[Path, tuple]]
) -> None:
    """Raise for the first entry that breaks the schema; `place` says in which file and at which key
    an entry stands.
    """
    for path in _not_finite(content):
        file, where = place(path)
        raise SettingsError(file, where, at(content, path), "is no finite number; give one")
    # A misspelt key comes first: it explains the missing one.
    errors = sorted(
        _validator(schema).iter_errors(content),
        key=lambda error: error.validator != "additionalProperties",
    )
    if not errors:
        return
    error, path = errors[0], tuple(errors[0].absolute_path)
    value, wanted = error.instance, error.validator_value
    if error.validator == "additionalProperties":
        known = list(error.schema.get("properties", {}))
        path = (*path, next(key for key in value if key not in known))
        value, cure = value[path[-1]], f"is an unknown key; {closest(path[-1], known)}"
    elif error.validator == "required":
        path = (*path, next(key for key in wanted if key not in value))
        value, cure = None, "is missing; add it"
    elif error.validator == "dependentRequired":
        given, path = next(
            (key, (*path, need))
            for key, needs in wanted.items()
            if key in value
            for need in needs
            if need not in value
        )
        value, cure = None, f"is missing; {given!r} needs it, add it"
    elif error.validator == "uniqueItems":
        double = next(item for index, item in enumerate(value) if item in value[:index])
        cure = f"repeats {double!r}; give each once"
    elif error.validator == "enum":
        cure = f"is not known; {closest(value, [str(item) for item in wanted])}"
    else:
        cure = f"must be {_expectation(error.validator, wanted)}; change it"
    about = (
        error.schema.get("description")
        if error.validator not in ("additionalProperties", "required", "dependentRequired")
        else None
    )
    file, where = place(path)
    raise SettingsError(file, where, value, cure + (f" ({about})" if about else ""))


def _not_finite(content: Any, path: tuple = ()) -> list[tuple]:
    """Where .nan and .inf stand: every comparison of a bound lets them through."""
    if isinstance(content, float):
        return [] if math.isfinite(content) else [path]
    items = (
        content.items()
        if isinstance(content, dict)
        else enumerate(content)
        if isinstance(content, list)
        else ()
    )
    return [found for key, item in items for found in _not_finite(item, (*path, key))]


def _expectation(validator: str, wanted: Any) -> str:
    words = {
        "minimum": "at least",
        "maximum": "at most",
        "exclusiveMinimum": "greater than",
        "exclusiveMaximum": "less than",
    }
    if validator in words:
        return f"{words[validator]} {wanted}"
    if validator == "type":
        kinds = [wanted] if isinstance(wanted, str) else [kind for kind in wanted if kind != "null"]
        names = {
            "object": "a block of `key: value` pairs",
            "array": "a list",
            "integer": "a whole number",
            "number": "a number",
            "string": "text",
            "boolean": "true or false",
        }
        return " or ".join(names[kind] for kind in kinds)
    if validator in ("minItems", "maxItems", "minProperties"):
        bound = "at most" if validator == "maxItems" else "at least"
        return f"{bound} {wanted} {'entry' if wanted == 1 else 'entries'} long"
    if validator == "multipleOf":
        return f"a multiple of {wanted}"
    return f"as {validator} {wanted} says"
