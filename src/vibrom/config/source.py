"""The modules of vibrom as text: found, parsed and read without importing them."""

import ast
from functools import cache
from pathlib import Path

PACKAGE = Path(__file__).parent.parent
DOCUMENTED = (ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)


@cache
def is_package(module: str) -> bool:
    """Is this full name that of a folder with an `__init__.py`?"""
    return PACKAGE.joinpath(*module.split(".")[1:], "__init__.py").is_file()


@cache
def is_module(module: str) -> bool:
    """Is there source for this full name, a package's or a module's?"""
    return module.split(".")[0] == "vibrom" and (
        is_package(module) or PACKAGE.joinpath(*module.split(".")[1:]).with_suffix(".py").is_file()
    )


def path(module: str) -> Path:
    """The file of `vibrom` or of a module below it, by its full name."""
    below = PACKAGE.joinpath(*module.split(".")[1:])
    return below / "__init__.py" if is_package(module) else below.with_suffix(".py")


@cache
def tree(module: str) -> ast.Module:
    """Its parsed source."""
    return parse(path(module))


def parse(file: Path) -> ast.Module:
    """A source file without docstrings."""
    parsed = ast.parse(file.read_bytes(), filename=str(file))
    _strip(parsed)
    return parsed


def _strip(node) -> None:
    """Remove the docstrings of a module, class or function and of what it defines."""
    if ast.get_docstring(node, clean=False) is not None:
        node.body = node.body[1:]
    for item in node.body:
        if isinstance(item, DOCUMENTED):
            _strip(item)


@cache
def _lines(module: str) -> list[bytes]:
    return path(module).read_bytes().splitlines()


def comment(module: str, node: ast.stmt) -> str:
    """What is said beside a statement, or in the lines above it where nothing is."""
    lines = _lines(module)
    beside = lines[(node.end_lineno or 0) - 1][node.end_col_offset :].strip()
    if beside.startswith(b"#"):
        return beside.lstrip(b"# ").decode()
    above: list[str] = []
    for line in reversed(lines[: node.lineno - 1]):
        if not line.strip().startswith(b"#"):
            break
        above.insert(0, line.strip().lstrip(b"# ").decode())
    return " ".join(above)
