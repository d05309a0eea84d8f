"""Shapes are what the comments beside them say: checked in the tests, at no cost elsewhere.

A field `x: np.ndarray  # (b, 2n) m`, an argument with such a comment, or one that the docstring
names as `x` (b, 2n), becomes an annotation of jaxtyping's, which beartype checks in every call:
within one call b is one number. Names stand for lengths, `*batch` for any number of axes; a length
that is computed, like steps + 1, is not compared.
"""

import ast
import re
import sys
import types
from dataclasses import is_dataclass
from functools import reduce
from importlib.machinery import PathFinder, SourceFileLoader
from operator import or_

import numpy as np
from beartype import beartype
from jaxtyping import Shaped, jaxtyped

from vibrom.config import source

CHECKED = ("vibrom.models.", "vibrom.latent.", "vibrom.solvers.periodic.")
DOORS = ("vibrom.models.rollout",)  # refuses wrong shapes in words of its own
ARRAYS = {"np.ndarray", "np.ndarray | None"}
LENGTH = re.compile(r"\*?\w+|\.\.\.|\w+(?: ?[-+*/] ?\w+)+")
NAMED = re.compile(r"`(\w+)` (\([^()]*\)(?: or \([^()]*\))*)")  # in a docstring
count = 0  # of classes and functions that are checked


def shape_of(text: str) -> str | None:
    """`(b, 2n)` in jaxtyping's words; None for what is no shape."""
    lengths = [length.strip() for length in text.strip("()").split(",")]
    if len(lengths) < 2 or not all(LENGTH.fullmatch(length) for length in lengths if length):
        return None
    return " ".join(_length(length) for length in lengths if length)


def _length(text: str) -> str:
    if text.isdecimal() or text == "...":
        return text
    if multiple := re.fullmatch(r"(\d+)(\w+)", text):
        return f"{multiple[2]}_times_{multiple[1]}"
    return text if text.lstrip("*").isidentifier() else "_"


def hint_of(annotation: ast.expr | None, words: str) -> object | None:
    """What beartype checks: an array of one of the shapes in these words."""
    kind = "" if annotation is None else ast.unparse(annotation)
    found = [shape_of(text) for text in re.findall(r"\([^()]*\)", words)]
    shapes = [Shaped[np.ndarray, text] for text in found if text is not None]
    if kind not in ARRAYS or not shapes:
        return None
    return reduce(or_, shapes, types.NoneType if "None" in kind else shapes[0])


def arguments(module: str, node: ast.FunctionDef) -> dict[str, object]:
    """Argument -> hint, of those whose shape is said beside them or in the docstring."""
    documented = dict(NAMED.findall(ast.get_docstring(node) or ""))
    given = [*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs]
    lines = [item.lineno for item in given]
    hints = {}
    for item in given:
        alone = lines.count(item.lineno) == 1 and item.lineno != node.lineno
        words = source.comment(module, item) if alone else ""
        hints[item.arg] = hint_of(item.annotation, words or documented.get(item.arg, ""))
    return {name: hint for name, hint in hints.items() if hint is not None}


def fields(module: str, node: ast.ClassDef) -> dict[str, object]:
    """Field -> hint."""
    declared = [item for item in node.body if isinstance(item, ast.AnnAssign)]
    hints = {
        ast.unparse(item.target): hint_of(item.annotation, source.comment(module, item))
        for item in declared
    }
    return {name: hint for name, hint in hints.items() if hint is not None}


def checked(function, hints):
    """The function, whose arguments are checked."""
    global count
    count += 1
    function.__annotations__ = hints
    return jaxtyped(typechecker=beartype)(function)


def check(module: types.ModuleType) -> None:
    """Check the functions and dataclasses that a module defines."""
    name = module.__name__
    parsed = ast.parse(source.path(name).read_bytes())
    for home, nodes in [(module, parsed.body)] + [
        (vars(module)[node.name], node.body)
        for node in parsed.body
        if isinstance(node, ast.ClassDef)
    ]:
        for node in nodes:
            function = vars(home).get(getattr(node, "name", ""))
            if isinstance(node, ast.FunctionDef) and isinstance(function, types.FunctionType):
                if hints := arguments(name, node):
                    setattr(home, node.name, checked(function, hints))
            elif is_dataclass(function) and (hints := fields(name, node)):
                function.__init__ = checked(function.__init__, hints)


class Loader(SourceFileLoader):
    """Loads a module and checks it."""

    def exec_module(self, module):
        super().exec_module(module)
        check(module)


class Finder:
    """Finds the modules that are checked."""

    @staticmethod
    def find_spec(name, path=None, target=None):
        if not name.startswith(CHECKED) or name in DOORS:
            return None
        spec = PathFinder.find_spec(name, path)
        if spec is not None and isinstance(spec.loader, SourceFileLoader):
            spec.loader = Loader(spec.loader.name, spec.loader.path)
        return spec


def install() -> None:
    """Check what is imported from now on."""
    assert not [name for name in sys.modules if name.startswith(CHECKED)]
    sys.meta_path.insert(0, Finder)
