"""Which code made a result: a digest of the modules behind it, and the versions of the packages
that they compute with.

A rule names its entry modules. Everything of vibrom that these import, directly or not, is behind
the result, and so are the package `__init__` files on the way. The digest is taken of the parsed
source: comments, docstrings and layout change nothing, code changes it. Packages count when one of
those modules imports them, so that a new mlflow does not train a network again. Packages that only
carry data (`CARRIERS`) are recorded in the artefact and make nothing run again.
"""

import ast
import atexit
import hashlib
import json
import os
import sys
from collections.abc import Iterable
from contextlib import suppress
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from vibrom import __version__
from vibrom.config import source
from vibrom.config.source import is_module, is_package, parse, tree

DISTRIBUTION = {"skfem": "scikit-fem", "yaml": "PyYAML", "sklearn": "scikit-learn"}
CARRIERS = frozenset({"xarray", "netCDF4", "yaml", "mlflow", "rich", "vibrom"})


def _stamp(path: Path) -> list[int]:
    status = path.stat()
    return [status.st_mtime_ns, status.st_size]


@cache
def _store() -> dict[str, dict]:
    """What earlier processes read of each module: parsing all of them again takes longer than the
    rest of this file's work.

    Kept beside the bytecode, for as long as this code and that file stay as they are.
    """
    path, code = (
        source.PACKAGE / "__pycache__" / f"provenance.{sys.implementation.cache_tag}.json",
        [_stamp(Path(file)) for file in (__file__, source.__file__)],
    )
    try:
        stored = json.loads(path.read_text())
    except (OSError, ValueError):
        stored = {}
    stored = stored if stored.get("code") == code else {"code": code}
    before = json.dumps(stored)

    def keep() -> None:
        if (now := json.dumps(stored)) != before:
            with suppress(OSError):  # a package that cannot be written to is parsed each time
                path.parent.mkdir(exist_ok=True)
                partial = path.with_suffix(f".{os.getpid()}")
                partial.write_text(now)
                os.replace(partial, path)

    atexit.register(keep)
    return stored


@cache
def _read(module: str) -> dict:
    """The stamp of a module's file, the names that it may import and the sha256 of its parsed
    source.
    """
    stored, stamp = _store(), _stamp(source.path(module))
    if stored.get(module, {}).get("stamp") != stamp:
        parsed = tree(module)
        stored[module] = {
            "stamp": stamp,
            "named": _named(module, parsed),
            "digest": hashlib.sha256(ast.dump(parsed).encode()).hexdigest(),
        }
    return stored[module]


def _named(module: str, parsed: ast.Module) -> list[str]:
    package = module.split(".") if is_package(module) else module.split(".")[:-1]
    found: set[str] = set()
    for node in ast.walk(parsed):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            parts = package[: len(package) - node.level + 1] if node.level else []
            home = ".".join(parts + ([node.module] if node.module else []))
            found |= {home} | {f"{home}.{alias.name}" for alias in node.names}
    return sorted(found)


@cache
def imports(module: str) -> frozenset[str]:
    """Every module that the source of `module` imports, of vibrom and of others, anywhere in the
    file.
    """
    return frozenset(
        name for name in _read(module)["named"] if name.split(".")[0] != "vibrom" or is_module(name)
    )


@cache
def modules_behind(*entries: str) -> frozenset[str]:
    """`entries` and all modules of vibrom that they reach by imports."""
    todo, seen = list(entries), set()
    while todo:
        module = todo.pop()
        if module in seen:
            continue
        seen.add(module)
        parts = module.split(".")
        todo += [".".join(parts[:length]) for length in range(1, len(parts))]
        todo += [name for name in imports(module) if name.split(".")[0] == "vibrom"]
    return frozenset(seen)


@cache
def data_digest(package: str) -> str:
    """sha256 of what lies below a package beside its code: published numbers, templates, style
    sheets.
    """
    folder = source.PACKAGE.joinpath(*package.split(".")[1:])

    def belongs(path: Path) -> bool:
        """Not what editors, numba or Python leave beside the sources."""
        passing = any(
            part.startswith(".") or part == "__pycache__" for part in path.relative_to(folder).parts
        ) or path.name.endswith("~")
        return path.suffix != ".py" and not passing and path.is_file()

    found = sorted(path for path in folder.rglob("*") if belongs(path))
    return hashlib.sha256(b"".join(path.read_bytes() for path in found)).hexdigest()


def digest(*entries: str) -> str:
    """sha256 over all modules behind `entries` and the data of their packages, 16 hex digits."""
    whole = hashlib.sha256()
    for module in sorted(modules_behind(*entries)):
        whole.update(f"{module} {_read(module)['digest']}\n".encode())
        if is_package(module) and module != "vibrom":
            whole.update(data_digest(module).encode())
    return whole.hexdigest()[:16]


def packages(*entries: str) -> frozenset[str]:
    """The third-party packages that the modules behind `entries` import."""
    roots = {name.split(".")[0] for module in modules_behind(*entries) for name in imports(module)}
    return frozenset(roots - set(sys.stdlib_module_names) - {"vibrom", ""})


@cache
def installed(package: str) -> str | None:
    """The version of an import package, read from its metadata; of this one from its source, which
    may be newer than what was installed.
    """
    if package == "vibrom":
        return __version__
    try:
        return version(DISTRIBUTION.get(package, package))
    except PackageNotFoundError:
        return None


def versions(names: Iterable[str]) -> dict[str, str]:
    """Distribution -> version of these import packages, where they are installed."""
    return {
        DISTRIBUTION.get(name, name): found for name in sorted(names) if (found := installed(name))
    }


@cache
def attributes(*entries: str) -> dict[str, str]:
    """What a rule passes on to its artefact, and runs again for when it changes."""
    python = f"{sys.version_info.major}.{sys.version_info.minor}"
    return {
        "source_digest": digest(*entries),
        "versions": json.dumps(
            {"python": python, **versions(packages(*entries) - CARRIERS)}, sort_keys=True
        ),
    }


def script_attributes(path: str | Path, names: tuple[str, ...]) -> dict[str, str]:
    """`attributes` of a script outside vibrom that computes with these packages."""
    python = f"{sys.version_info.major}.{sys.version_info.minor}"
    return {
        "source_digest": hashlib.sha256(ast.dump(parse(Path(path))).encode()).hexdigest()[:16],
        "versions": json.dumps({"python": python, **versions(names)}, sort_keys=True),
    }


def completed(stored: dict[str, str]) -> dict[str, str]:
    """`attributes` as the artefact keeps them: with the packages that carry the data in the process
    that writes it.
    """
    carried = versions({"vibrom", "xarray", "netCDF4"})
    return stored | {
        "versions": json.dumps(json.loads(stored["versions"]) | carried, sort_keys=True)
    }
