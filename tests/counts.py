"""How large things are, and how many files one more of each kind takes.

`python tests/counts.py` prints it; tests/test_house_rules.py holds us to it.
"""

import ast
import re
from functools import cache
from pathlib import Path

import grimp

ROOT = Path(__file__).parents[1]
SOURCE = ROOT / "src/vibrom"
LINES, FUNCTION, ARGUMENTS, COLUMNS = 300, 50, 8, 100
# A file that a page of docs/ adds, in a fenced block below its name.
ADDED = re.compile(r"`([\w./]+\.(?:py|yaml))`:\n\n```\w+\n(.*?)```", re.DOTALL)
# One more of these -> the folder of its file, and how many files it may take at most.
PLUGS = {
    "study": ("studies", 3),  # with a table and a figure of its own
    "experiment": ("experiments", 1),
    "output": ("report/tables", 1),
    "body": ("bodies", 1),
    "integrator": ("solvers/reduced/steppers", 1),
}


@cache
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


def longest_lines():
    """(columns, file:line) of the longest line of code, prose and configuration, tables aside."""
    folders = [SOURCE, ROOT / "tests", ROOT / "benchmarks", ROOT / "workflow/scripts"]
    pages = [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md"), *(ROOT / "config").glob("*.md")]
    for folder, kind in (("config", "yaml"), ("profiles", "yaml"), ("workflow", "smk")):
        pages += (ROOT / folder).rglob(f"*.{kind}")
    return max(
        (len(line), f"{path.relative_to(ROOT)}:{number}")
        for path in [*pages, *(path for folder in folders for path in folder.rglob("*.py"))]
        for number, line in enumerate(path.read_text().splitlines(), 1)
        if "noqa: E501" not in line and not line.startswith("|")
    )


def circles():
    """Chains of imports that lead back to where they begin, as lists of modules."""
    graph = grimp.build_graph("vibrom", cache_dir=None)
    found = []
    for module in sorted(graph.modules):
        for other in sorted(graph.find_modules_directly_imported_by(module)):
            if other > module and (back := graph.find_shortest_chain(other, module)):
                found.append([module, *back])
    return found


def added_by_docs():
    """File -> its text, of all that the pages of docs/ add."""
    pages = "\n".join(path.read_text() for path in sorted((ROOT / "docs").rglob("*.md")))
    return dict(ADDED.findall(pages))


def main():
    """Print all of them."""
    columns, where = longest_lines()
    print(f"longest line: {columns} columns ({where})")
    for what, limit, measured in (
        ("lines of a file", LINES, files()),
        ("lines of a function", FUNCTION, [(name, lines) for name, lines, _ in functions()]),
        ("arguments", ARGUMENTS, [(name, count) for name, _, count in functions()]),
    ):
        name, most = max(measured, key=lambda item: item[1])
        over = [f"{each} ({size})" for each, size in measured if size > limit]
        print(f"{what}: at most {most} ({name}); over {limit}: {len(over)} {', '.join(over)}")
    print(f"circles of imports: {len(circles())}")
    for plug, (folder, most) in PLUGS.items():
        print(f"one more {plug}: {most} or fewer files, its own in src/vibrom/{folder}")


if __name__ == "__main__":
    main()
