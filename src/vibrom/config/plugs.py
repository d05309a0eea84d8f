"""What can be plugged in: bodies, effects, signals, methods, experiments and studies, read from
their text.

A plug is one file in its folder. Its settings are the fields of its dataclass, of the kinds that
`kinds` names, with what the comment beside a field says as their description. Plugs import
numerical packages, which would cost seconds in every plan of hundreds of jobs; so the declaration
is evaluated from the text, with the names that the file itself defines or imports.
"""

import ast
import typing
from collections.abc import Iterable
from contextlib import suppress
from functools import cache, partial
from typing import Annotated, Any

import msgspec
from msgspec import Meta

from vibrom.config import kinds, source
from vibrom.config.errors import ConfigError
from vibrom.config.scene import STAGES, USUAL_STAGE, Block

# Folder -> the method that tells the class of a plug from what stands beside it; None: its name.
PLUGS = {
    "bodies": "build",
    "effects": "assemble",
    "signals": "at",
    "methods": "fit",
    "experiments": "ask",
    "studies": None,
}
BUILT_IN = {word.__name__: word for word in (float, int, str, bool, list, dict, tuple)}
FOREIGN = {"typing": typing, "msgspec": msgspec, "vibrom.config.kinds": kinds}


class PlugError(ConfigError):
    """A plug whose settings cannot be read from its text; the message names the cure."""


@cache
def names(folder: str) -> tuple[str, ...]:
    """The plugs in a folder of vibrom: effects, report/tables, ..."""
    found = [file.stem for file in (source.PACKAGE / folder).glob("*.py") if file.stem[0] != "_"]
    return tuple(sorted(name for name in found if folder not in PLUGS or class_of(folder, name)))


def settings_of(folder: str, name: str) -> type[Block]:
    """The settings of a plug, as a class that msgspec knows."""
    return declared(module_of(folder, name), class_of(folder, name) or "")


@cache
def declared(module: str, name: str) -> type[Block]:
    """The fields of a dataclass of vibrom, those that it inherits first, as such a class."""
    fields = _fields(module, name)
    made: Any = msgspec.defstruct(
        name, list(fields.values()), bases=(Block,), kw_only=True, frozen=True, module=module
    )
    return made


def kinds_of(settings: type[Block]) -> dict[str, Any]:
    """Setting -> its kind."""
    return {field.name: field.type for field in msgspec.structs.fields(settings)}


def must_be_given(settings: type[Block]) -> list[str]:
    """The settings without a default."""
    return [field.name for field in msgspec.structs.fields(settings) if field.required]


def constants(folder: str, name: str) -> dict[str, Any]:
    """The plug's constants that are literals: of its module, of its last class and of the classes
    above that.
    """
    module = module_of(folder, name)
    found, classes = _literals(names_of(module).assigned), list(names_of(module).classes)
    return found | _class_constants(module, classes[-1]) if classes else found


def _class_constants(module: str, name: str) -> dict[str, Any]:
    node = names_of(module).classes[name]
    found: dict[str, Any] = {}
    for parent in _parents(module, node):
        found |= _class_constants(*parent)
    return found | _literals(assigned(node.body))


def _literals(values: dict[str, ast.expr]) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for name, value in values.items():
        with suppress(ValueError):
            found[name] = ast.literal_eval(value)
    return found


def assigned(body: list[ast.stmt]) -> dict[str, ast.expr]:
    """What is assigned to each name among these statements."""
    found: dict[str, ast.expr] = {}
    for node in body:
        if isinstance(node, ast.Assign):
            found |= {ast.unparse(target): node.value for target in node.targets}
        elif isinstance(node, ast.AnnAssign) and node.value:
            found[ast.unparse(node.target)] = node.value
    return found


def in_order(effects: Iterable[str]) -> list[str]:
    """The names of effects in the order in which they add up."""

    def place(name: str) -> tuple[int, str]:
        return STAGES.index(constants("effects", name).get("STAGE", USUAL_STAGE)), name

    return sorted(effects, key=place)


def module_of(folder: str, name: str) -> str:
    """The full name of a plug's module."""
    return f"vibrom.{folder.replace('/', '.')}.{name}"


def defaults_of(settings: type[Block]) -> dict[str, Any]:
    """Setting -> its default in plain form, of those that have one."""
    fields = msgspec.structs.fields(settings)
    return {
        field.name: msgspec.to_builtins(field.default_factory())
        for field in fields
        if not field.required
    }


@cache
def class_of(folder: str, name: str) -> str | None:
    """The last class of a plug's file that has the method of its folder; of a study the class of
    the same name.
    """
    module = module_of(folder, name)
    classes, method = names_of(module).classes, PLUGS[folder]
    if method is None:
        return next((item for item in classes if item.lower() == name.replace("_", "")), None)
    found = [item for item in classes if _answers(module, item, method)]
    return found[-1] if found else None


def _answers(module: str, name: str, question: str) -> bool:
    """Does the class define or inherit the method?"""
    node = names_of(module).classes[name]
    own = any(isinstance(item, ast.FunctionDef) and item.name == question for item in node.body)
    return own or any(_answers(*parent, question) for parent in _parents(module, node))


def _parents(module: str, node: ast.ClassDef) -> list[tuple[str, str]]:
    """Module and name of the bases that are classes of vibrom."""
    homes = [names_of(module).home(ast.unparse(base)) for base in node.bases]
    return [home for home in homes if home and home[1] in names_of(home[0]).classes]


def _fields(module: str, name: str) -> dict[str, tuple]:
    """Field -> (its name, its kind with a description, its default where it has one)."""
    scope = names_of(module)
    node = scope.classes[name]
    fields: dict[str, tuple] = {}
    for parent in _parents(module, node):
        fields |= _fields(*parent)
    for item in node.body:
        if isinstance(item, ast.AnnAssign) and "ClassVar" not in ast.unparse(item.annotation):
            key = ast.unparse(item.target)
            try:
                fields[key] = (key, *_declaration(module, item, scope))
            except Exception as error:
                cure = "take a kind of vibrom.config.kinds, and a literal as the default"
                where = f"{source.path(module)}: {name}.{key}"
                raise PlugError(
                    f"{where} cannot be read from the text ({error}); {cure}"
                ) from error
    return fields


def _declaration(module: str, item: ast.AnnAssign, scope: "Names") -> tuple:
    kind, about = scope.evaluate(item.annotation), source.comment(module, item)
    kind = Annotated[kind, Meta(description=about)] if about else kind
    return (kind,) if (default := _default(item.value, scope)) is None else (kind, default)


def _default(node: ast.expr | None, scope: "Names") -> Any:
    """What msgspec takes for the default; None where there is none."""
    if isinstance(node, ast.Call) and ast.unparse(node.func).split(".")[-1] == "field":
        given = {keyword.arg: keyword.value for keyword in node.keywords}
        node = given.get("default_factory", given.get("default"))
        if isinstance(node, ast.Lambda):
            node = node.body
        elif node is not None and "default_factory" in given:
            return msgspec.field(default_factory=scope.evaluate(node))
    if node is None:
        return None
    scope.evaluate(node)  # an error is raised here
    return msgspec.field(default_factory=partial(scope.evaluate, node))


class Names:
    """What the names in a module stand for, as far as declarations of settings use them."""

    def __init__(self, module: str):
        self.module = module
        self.classes: dict[str, ast.ClassDef] = {}
        self.assigned = assigned(source.tree(module).body)
        self.imported: dict[str, tuple[str, str]] = {}  # name -> module, and its name there
        for node in source.tree(module).body:
            if isinstance(node, ast.ClassDef):
                self.classes[node.name] = node
            elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
                for alias in node.names:
                    self.imported[alias.asname or alias.name] = node.module, alias.name

    def home(self, name: str) -> tuple[str, str] | None:
        """Module and name of what a name stands for, where that is in vibrom."""
        module, there = self.imported.get(name, (self.module, name))
        return (module, there) if source.is_module(module) else None

    def evaluate(self, node: ast.expr) -> Any:
        """The value of an expression of the module."""
        code = compile(ast.Expression(node), self.module, "eval")
        return eval(code, {"__builtins__": {}}, self)  # type: ignore[arg-type]

    def __getitem__(self, name: str) -> Any:
        module, there = self.imported.get(name, (self.module, name))
        if module in FOREIGN:
            return getattr(FOREIGN[module], there)
        if module != self.module and source.is_module(module):
            return names_of(module)[there]
        if name in self.classes:
            return declared(module, name)
        if name in self.assigned:
            return self.evaluate(self.assigned[name])
        return BUILT_IN[name]


names_of = cache(Names)
