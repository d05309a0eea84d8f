"""How large things may be, at 100 columns, and how many files one more of each kind takes.

What is larger says why, here; an exception that is no longer one is an error too.
"""

import shutil
import subprocess
import sys

import counts
import pytest

from vibrom.config import plugs, source

# file -> why it is longer
LONG_FILES: dict[str, str] = {}
# file:function -> why it is longer
LONG_FUNCTIONS: dict[str, str] = {}
# file:function -> why it takes more
MANY_ARGUMENTS: dict[str, str] = {
    "solvers/full/newmark.py:Newmark.run": "a motion: four are needed, the others have defaults",
    "steps/fit.py:run": "the named inputs and parameters of a rule",
}


@pytest.mark.parametrize(
    ("measured", "limit", "exceptions"),
    [
        (lambda: counts.files(), counts.LINES, LONG_FILES),
        (lambda: [found[:2] for found in counts.functions()], counts.FUNCTION, LONG_FUNCTIONS),
        (lambda: [found[::2] for found in counts.functions()], counts.ARGUMENTS, MANY_ARGUMENTS),
    ],
    ids=["lines of a file", "lines of a function", "arguments"],
)
def test_what_is_larger_says_why(measured, limit, exceptions):
    larger = {name: size for name, size in measured() if size > limit}
    assert larger.keys() == exceptions.keys(), larger


def test_no_line_is_longer_than_the_page():
    columns, where = counts.longest_lines()
    assert columns <= counts.COLUMNS, where


def test_no_imports_lead_back_to_where_they_begin():
    assert counts.circles() == []


def test_a_study_with_its_table_and_figure_is_three_files():
    """Those that docs/ adds, which another test runs through the workflow."""
    added = [name for name in counts.added_by_docs() if "loose_integration" in name]
    assert len(added) == counts.PLUGS["study"][1]
    others = {"experiments": 1, "effects": 1}
    for folder, most in others.items():
        names = [name for name in counts.added_by_docs() if f"vibrom/{folder}/" in name]
        assert len(names) == most


def test_one_more_is_one_file(tmp_path):
    """A copy of a plug under another name is found, and its settings are read."""
    copied = tmp_path / "vibrom"
    shutil.copytree(source.PACKAGE, copied, ignore=shutil.ignore_patterns("__pycache__"))
    code = "from vibrom.config import plugs\n"
    for plug in ("body", "integrator", "output", "experiment"):
        folder, _ = counts.PLUGS[plug]
        first = next(name for name in plugs.names(folder) if name != "space")
        shutil.copy(copied / folder / f"{first}.py", copied / folder / "one_more.py")
        code += f"assert 'one_more' in plugs.names({folder!r})\n"
        code += f"{folder!r} in plugs.PLUGS and plugs.settings_of({folder!r}, 'one_more')\n"
    environment = {"PYTHONPATH": str(tmp_path), "PATH": "/usr/bin:/bin"}
    subprocess.run([sys.executable, "-c", code], check=True, env=environment)
