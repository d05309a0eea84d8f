"""What can be plugged in: effects, methods and experiments, read from their source text without
importing them.

A plug is one file in its folder. Its settings are the fields of its dataclass, what it needs are
constants of its module; both are literals in the text, so that a workflow with hundreds of jobs is
planned without loading a single numerical package.
"""

import ast
from dataclasses import dataclass
from functools import cache
from pathlib import Path

PACKAGE = Path(__file__).parent.parent
# The method that the plug's class is asked to have.
QUESTION = {"effects": "assemble", "methods": "fit"}
DOCUMENTED = (ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)


@dataclass(frozen=True)
class Field:
    """One setting: its type as written, and whether it must be given."""

    annotation: str
    required: bool


def names(folder: str) -> list[str]:
    """The plugs in `effects`, `methods` or `experiments`."""
    return sorted(
        path.stem for path in (PACKAGE / folder).glob("*.py") if not path.stem.startswith("_")
    )


def is_package(module: str) -> bool:
    return PACKAGE.joinpath(*module.split(".")[1:], "__init__.py").is_file()


def is_module(module: str) -> bool:
    """Is there source for this full name, a package's or a module's?"""
    return module.split(".")[0] == "vibrom" and (
        is_package(module) or PACKAGE.joinpath(*module.split(".")[1:]).with_suffix(".py").is_file()
    )


def source(module: str) -> Path:
    """The file of `vibrom` or of a module below it, by its full name."""
    path = PACKAGE.joinpath(*module.split(".")[1:])
    return path / "__init__.py" if is_package(module) else path.with_suffix(".py")


@cache
def tree(module: str) -> ast.Module:
    """Its parsed source."""
    return parse(source(module))


def parse(path: Path) -> ast.Module:
    """A source file without docstrings."""
    parsed = ast.parse(path.read_bytes(), filename=str(path))
    _strip(parsed)
    return parsed


def _strip(node) -> None:
    """Remove the docstrings of a module, class or function and of what it defines."""
    if ast.get_docstring(node, clean=False) is not None:
        node.body = node.body[1:]
    for item in node.body:
        if isinstance(item, DOCUMENTED):
            _strip(item)


def constants(folder: str, name: str) -> dict[str, object]:
    """The plug's constants that are literals: those of its module and, where it defines one class,
    those of the class and of the classes above it.
    """
    module = f"vibrom.{folder.replace('/', '.')}.{name}"
    classes = [node for node in tree(module).body if isinstance(node, ast.ClassDef)]
    own = _class_constants(module, classes[-1]) if classes else {}
    return _literals(tree(module).body) | own


def _class_constants(module: str, node: ast.ClassDef) -> dict[str, object]:
    found: dict[str, object] = {}
    for home, parent in _parents(module, node):
        found |= _class_constants(home, parent)
    return found | _literals(node.body)


def _literals(body: list[ast.stmt]) -> dict[str, object]:
    """The assignments of literals to a name among these statements."""
    found: dict[str, object] = {}
    for node in body:
        targets = (
            node.targets
            if isinstance(node, ast.Assign)
            else [node.target]
            if isinstance(node, ast.AnnAssign) and node.value
            else []
        )
        for target in targets:
            if isinstance(target, ast.Name):
                try:
                    found[target.id] = ast.literal_eval(node.value)
                except ValueError:
                    continue
    return found


def settings_of(folder: str, name: str) -> dict[str, Field]:
    """The plug's settings: the fields of its one class, inherited ones included."""
    module = f"vibrom.{folder}.{name}"
    classes = [
        node
        for node in tree(module).body
        if isinstance(node, ast.ClassDef) and _answers(module, node, QUESTION[folder])
    ]
    return _fields(module, classes[-1]) if classes else {}


def _answers(module: str, node: ast.ClassDef, question: str) -> bool:
    """Does the class define or inherit the method?"""
    own = any(isinstance(item, ast.FunctionDef) and item.name == question for item in node.body)
    return own or any(_answers(home, parent, question) for home, parent in _parents(module, node))


def _fields(module: str, node: ast.ClassDef) -> dict[str, Field]:
    fields: dict[str, Field] = {}
    for parent_module, parent in _parents(module, node):
        fields |= _fields(parent_module, parent)
    for item in node.body:
        if isinstance(item, ast.AnnAssign) and isinstance(item.target, ast.Name):
            annotation = ast.unparse(item.annotation)
            if not annotation.startswith("ClassVar"):
                fields[item.target.id] = Field(annotation, _required(item.value))
    return fields


def _required(value: ast.expr | None) -> bool:
    """A field without a default, `field(...)` of dataclasses included."""
    if (
        isinstance(value, ast.Call)
        and getattr(value.func, "id", getattr(value.func, "attr", "")) == "field"
    ):
        return not any(keyword.arg in ("default", "default_factory") for keyword in value.keywords)
    return value is None


def _parents(module: str, node: ast.ClassDef) -> list[tuple[str, ast.ClassDef]]:
    """The class's bases that are defined in vibrom, with the module of each."""
    origin = {
        item.name: (module, item.name)
        for item in tree(module).body
        if isinstance(item, ast.ClassDef)
    }
    for item in tree(module).body:
        if isinstance(item, ast.ImportFrom) and item.module and is_module(item.module):
            origin |= {
                alias.asname or alias.name: (item.module, alias.name) for alias in item.names
            }
    found = []
    for base in node.bases:
        home, name = origin.get(ast.unparse(base), (None, None))
        if home and is_module(home):
            found += [
                (home, item)
                for item in tree(home).body
                if isinstance(item, ast.ClassDef) and item.name == name
            ]
    return found
