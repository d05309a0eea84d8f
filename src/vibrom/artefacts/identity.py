"""Whose an artefact is, what it was made from, and whether it still holds what was written.

Three attributes say so: `content`, a digest of all variables and attributes; `asked`, the
parameters of the rule that made it; and `made_from`, the `content` of each artefact that the rule
read. Where a file lies says whose it must be: <scene>/full_order/<name>.nc, or
<scene>/<method>/<seed folder>/<name>.nc.
"""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np
import xarray as xr

from vibrom.artefacts.files import DataError
from vibrom.config.digest import digest
from vibrom.config.places import FULL_ORDER, UNSEEDED

BLOCK = 2**25  # bytes that are read at a time
FITTED_ONCE = -1  # the attribute `seed` of what is made without one
ROLES = ("train", "test")  # artefacts that are named by their role, and not by their kind
SEED_FOLDER = re.compile(rf"{UNSEEDED}|seed_(\d+)")
DERIVED = ("provenance", "checkpoint")  # parameters that say nothing of what is asked
AGAIN = "delete it and run again"
OLDEST = (0, 2)  # version whose artefacts are read; see CHANGELOG.md
STALE = {
    "asked": "made with other settings",
    "source_digest": "made by other code",
    "versions": "made with other packages",
    "made_from": "made from other data",
}


def attributes_of(path: str | Path) -> dict[str, Any]:
    """The attributes of an artefact, without its data."""
    try:
        with netCDF4.Dataset(path) as file:
            return {name: file.getncattr(name) for name in file.ncattrs()}
    except (OSError, RuntimeError) as error:
        raise unreadable(path, error) from error


def unreadable(path: str | Path, error: Exception) -> DataError:
    """The error for a file that cannot be opened: one that is torn is made again, no other."""
    if isinstance(error, PermissionError):
        return DataError(f"{path}: may not be read ({error.strerror}); change its permissions")
    return DataError(f"{path}: not a readable netCDF file ({str(error).splitlines()[0]}); {AGAIN}")


def place(path: str | Path) -> dict[str, Any]:
    """The attributes that the artefact at this path must have; none where the path says nothing."""
    above, name = Path(path).parts[:-1], Path(path).stem
    what = {"role" if name in ROLES else "kind": name}
    if len(above) > 1 and above[-1] == FULL_ORDER:
        return {"scene": above[-2], "method": FULL_ORDER, "seed": FITTED_ONCE, **what}
    if len(above) > 2 and (seed := SEED_FOLDER.fullmatch(above[-1])):
        number = FITTED_ONCE if seed[1] is None else int(seed[1])
        return {"scene": above[-3], "method": above[-2], "seed": number, **what}
    return {}


def check_place(path: str | Path, attributes: Mapping[str, Any]) -> None:
    """Raise `DataError` for the artefact of another scene, model, seed or kind."""
    for key, wanted in place(path).items():
        if (found := np.asarray(attributes.get(key)).tolist()) != wanted:
            raise DataError(f"{path}: {key} is {found!r}, but {wanted!r} belongs here; {AGAIN}")


def check_version(path: str | Path, attributes: Mapping[str, Any]) -> None:
    """Raise `DataError` for an artefact of a version of vibrom that stored other things. One that
    an outside tool wrote names none, and is judged by what it holds.
    """
    found = re.search('"vibrom": "([^"]*)"', str(attributes.get("versions")))
    made_by = found[1] if found else ""
    number = tuple(int(part) for part in re.findall(r"\d+", made_by)[:2])
    if number and number < OLDEST:
        oldest = ".".join(map(str, OLDEST))
        raise DataError(
            f"{path}: made by vibrom {made_by}, and artefacts are read from version {oldest} on; "
            "make it again, or open it with that version"
        )


def content(dataset: xr.Dataset) -> str:
    """sha256 over names, dimensions, values and attributes, 16 hex digits; `content` itself does
    not count.
    """
    whole = hashlib.sha256(_text(dataset.attrs).encode())
    for name in sorted(map(str, dataset.variables)):
        array = dataset.variables[name]
        whole.update(f"\n{name} {array.dims} {array.shape} {_text(array.attrs)}\n".encode())
        if not array.size:  # a file keeps no kind of none
            continue
        if array.dtype.kind in "OSU":
            whole.update("\0".join(map(str, array.values.ravel())).encode())
        else:
            whole.update(array.dtype.str.encode())
            for values in _blocks(array):
                whole.update(np.ascontiguousarray(values).data)
    return whole.hexdigest()[:16]


def _blocks(array: xr.Variable) -> Iterator[np.ndarray]:
    """The values, some rows at a time: they may lie on disk and be larger than memory."""
    if array.nbytes <= BLOCK:
        yield np.asarray(array.values)
        return
    rows = max(1, BLOCK * len(array) // array.nbytes)
    for first in range(0, len(array), rows):
        yield np.asarray(array[first : first + rows].values)


def _text(attributes: Mapping[str, Any]) -> str:
    """Attributes as they come back from a file: a list of one is its entry."""
    plain = {key: np.asarray(value).ravel().tolist() for key, value in attributes.items()}
    return repr(sorted((key, plain[key]) for key in plain if key != "content"))


def check_content(path: str | Path, dataset: xr.Dataset) -> None:
    """Raise `DataError` where the artefact is not what was written; one without a digest, by an
    outside tool, is believed.
    """
    written = dataset.attrs.get("content")
    if written is not None and written != content(dataset):
        raise DataError(f"{path}: damaged, as its content is not what was written; {AGAIN}")


def asked(parameters: Mapping[str, Any]) -> str:
    """What a rule asks for, as text."""
    return json.dumps(
        {key: value for key, value in parameters.items() if key not in DERIVED}, sort_keys=True
    )


def made_from(inputs: Mapping[str, Any]) -> str:
    """The `content` of the artefacts that a rule reads, by the names of its inputs, as text; of a
    user's file a digest of its bytes.
    """
    found = {}
    for name, paths in inputs.items():
        each = [paths] if isinstance(paths, str) else list(paths)
        known = [_content_of(path) for path in each]
        found[name] = known[0] if isinstance(paths, str) else known
    return json.dumps(found, sort_keys=True)


def _content_of(path: str) -> str:
    now = Path(path).stat()
    which = now.st_dev, now.st_ino, now.st_size, now.st_mtime_ns, now.st_ctime_ns
    return _content_as_of(path, which)


@cache
def _content_as_of(path: str, _which: tuple[int, ...]) -> str:
    """Read once: a plan asks for that of a structure a hundred times."""
    if path.endswith(".nc") and (written := attributes_of(path).get("content")):
        return str(written)
    return digest(Path(path))


def stale(
    path: str | Path,
    parameters: Mapping[str, Any],
    provenance: Mapping[str, str],
    inputs: Mapping[str, Any],
) -> str | None:
    """Why the artefact at `path` is not what its rule would make now, in words, or None.

    `inputs` are those that exist. What an outside tool does not say is not compared.
    """
    try:
        with xr.open_dataset(path, engine="netcdf4", cache=False) as opened:
            attributes = opened.attrs
            check_place(path, attributes)
            check_content(path, opened)
        wanted = {
            "asked": json.loads(asked(parameters)),
            "source_digest": provenance["source_digest"],
            "versions": json.loads(provenance["versions"]),
            "made_from": json.loads(made_from(inputs)),
        }
        stored = {
            key: value if key == "source_digest" else json.loads(value)
            for key, value in attributes.items()
            if key in wanted
        }
    except DataError as error:
        return str(error).removeprefix(f"{path}: ").partition(";")[0]
    except (OSError, ValueError, RuntimeError):
        return "not a readable netCDF file"
    for key in stored:
        for where, old, new in differences(stored[key], wanted[key]):
            # Packages that only carry data are stored beside; an input may be yet to be made.
            if key == "asked" or new is not None:
                return f"{STALE[key]} ({where}{old!r}, now {new!r})"
    return None


def differences(old: Any, new: Any, path: str = "") -> Iterator[tuple[str, Any, Any]]:
    """Where two plain values differ: dotted key, old and new."""
    if isinstance(old, dict) and isinstance(new, dict):
        for key in sorted({*old, *new}):
            yield from differences(old.get(key), new.get(key), f"{path}.{key}".lstrip("."))
    elif old != new:
        yield (f"{path} = " if path else ""), old, new
