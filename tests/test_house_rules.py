"""How large things may be: files, functions and lists of arguments, at 100 columns.

What is larger says why, here; an exception that is no longer one is an error too.
"""

import ast
from pathlib import Path

import pytest

LINES, FUNCTION, ARGUMENTS = 300, 50, 8
SOURCE = Path(__file__).parents[1] / "src/vibrom"
# file -> why it is longer
LONG_FILES: dict[str, str] = {}
# file:function -> why it is longer
LONG_FUNCTIONS: dict[str, str] = {}
# file:function -> why it takes more
MANY_ARGUMENTS: dict[str, str] = {
    "solvers/full/newmark.py:Newmark.run": "a motion: four are needed, the others have defaults",
    "steps/ask.py:run": "the named inputs and parameters of a rule",
    "steps/fit.py:run": "the named inputs and parameters of a rule",
}


def functions():
    """(file:qualified name, lines without the docstring, arguments) of every function."""
    found = []
    for path in sorted(SOURCE.rglob("*.py")):
        name = str(path.relative_to(SOURCE))
        stack = [(ast.parse(path.read_text()), "")]
        while stack:
            node, home = stack.pop()
            for item in ast.iter_child_nodes(node):
                named = isinstance(item, (ast.FunctionDef, ast.ClassDef))
                stack.append((item, f"{home}{item.name}." if named else home))
                if isinstance(item, ast.FunctionDef):
                    found.append((f"{name}:{home}{item.name}", body_lines(item), arguments(item)))
    return found


def body_lines(function):
    """Lines of the body; a docstring is no length to be ashamed of."""
    first = function.body[0]
    documented = ast.get_docstring(function) is not None
    start = first.end_lineno + 1 if documented else first.lineno
    return function.end_lineno - start + 1


def arguments(function):
    """How many a caller can give, `self` and `cls` left out."""
    given = function.args
    names = [item.arg for item in (*given.posonlyargs, *given.args, *given.kwonlyargs)]
    return len([name for name in names if name not in ("self", "cls")])


def files():
    """(file, lines)."""
    return [
        (str(path.relative_to(SOURCE)), len(path.read_text().splitlines()))
        for path in sorted(SOURCE.rglob("*.py"))
    ]


@pytest.mark.parametrize(
    ("measured", "limit", "exceptions"),
    [
        (lambda: files(), LINES, LONG_FILES),
        (lambda: [(name, lines) for name, lines, _ in functions()], FUNCTION, LONG_FUNCTIONS),
        (lambda: [(name, count) for name, _, count in functions()], ARGUMENTS, MANY_ARGUMENTS),
    ],
    ids=["lines of a file", "lines of a function", "arguments"],
)
def test_what_is_larger_says_why(measured, limit, exceptions):
    larger = {name: size for name, size in measured() if size > limit}
    assert larger.keys() == exceptions.keys(), larger
