"""Every command that README, docs and the comments of the configuration show is run, in a copy of
the repository that is laid out as the page says. A command that nothing here can run is a failure.

What takes minutes is run as far as it says that it would run: Snakemake plans its jobs, make its
recipes, pytest collects, and of benchmarks one number stands for what is measured.
"""

import os
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Callable
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

import pytest
from pages import FENCED, FILE, PAGES, blocks, shown
from project_copy import ROOT, change, copy, plan

from benchmarks import __main__ as benchmarks
from benchmarks.table import Row

HERE = Path(sys.executable).parent
NO_INDEX = "error sending request|Failed to fetch|dns error|not found in the package registry"


def runs(words: list[str], folder: Path) -> str:
    """What a command says that ends well."""
    path = f"{folder / '.venv/bin'}:{HERE}:{os.environ['PATH']}"
    known = {"PATH": path, "PYTHONPATH": str(folder / "src"), "VIRTUAL_ENV": str(folder / ".venv")}
    answer = subprocess.run(
        words, cwd=folder, capture_output=True, text=True, env=os.environ | known
    )
    said = answer.stdout + answer.stderr
    if answer.returncode and "pip" in words and re.search(NO_INDEX, said):
        pytest.skip("no index of packages is within reach")
    assert answer.returncode == 0, said[-3000:]
    return said


def snakemake(words: list[str], folder: Path) -> None:
    """Which jobs would run."""
    quiet = words[1:] if "--list" in words else [*words[1:], "--dry-run", "--quiet"]
    if "profiles/slurm" in words:  # whose plugin is in the folder's own environment
        runs(["python", "-m", "snakemake", *quiet], folder)
        return
    source = next(place / "src" for place in (folder, *folder.parents) if (place / "src").exists())
    answer = plan(folder, *quiet, PYTHONPATH=str(source))
    assert answer.returncode == 0, (answer.stdout + answer.stderr)[-3000:]


def make(words: list[str], folder: Path) -> None:
    """What make would do; every program, module and file of that is there."""
    recipe = runs([*words, "--dry-run"], folder)
    for program in re.findall(r"\.venv/bin/([\w-]+)", recipe):
        assert (HERE / program).exists(), program
    for module in re.findall(r"python -m ([\w.]+)", recipe):
        assert find_spec(module), module
    for name in re.findall(r"(?<=[ =])(?:tests|envs)/\S+", recipe):
        assert (ROOT / name).exists(), name


def vibrom(words: list[str], folder: Path) -> None:
    if "compare" in words:
        (folder / "results").mkdir(exist_ok=True)
        shutil.copy(folder / "config/reference_scores.csv", folder / "results/scores.csv")
    runs([sys.executable, "-m", *words], folder)


def python(words: list[str], folder: Path) -> None:
    if words[1:3] != ["-m", "benchmarks"]:
        runs([sys.executable, *words[1:]], folder)
        return
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        for name in words[3:] or benchmarks.NAMES:
            module = import_module(f"benchmarks.{name}")
            patch.setattr(module, "measure", lambda note, name=name: [Row(name, "time", 1.0, "s")])
            patch.setattr(module, "figures", lambda rows: {}, raising=False)
        assert benchmarks.main(words[3:]) == 0
    assert (folder / "results/benchmarks.html").exists()


def pip(words: list[str], folder: Path) -> None:
    """From a checkout, into an environment that has all which it asks for."""
    said = runs([*words, "--dry-run", "--no-build-isolation", "--no-index"], folder)
    assert "Would install vibrom" in said


def activate(words: list[str], folder: Path) -> None:
    said = runs(
        ["sh", "-c", f"{shlex.join(words)} && python -c 'import sys; print(sys.prefix)'"], folder
    )
    assert said.split() == [str(folder / ".venv")]


# Program -> what runs a line that begins with it.
RUN: dict[str, Callable[[list[str], Path], object]] = {
    "snakemake": snakemake,
    "make": make,
    "vibrom": vibrom,
    "python": python,
    "pytest": lambda words, folder: runs([*words, "--collect-only", "-q"], folder),
    "pip": pip,
    "uv": runs,
    ".": activate,
}


def overlays(page: str) -> list[str]:
    return [block for block in blocks(PAGES[page], "yaml") if block.startswith("scenes:")]


def checkout(folder: Path, page: str) -> Path:
    """A copy of the repository, its environment, and the files that a page asks for. Of the scenes
    and seeds of its configuration there is one: a plan of all takes seconds.
    """
    copy(folder, "src", "tests")
    for name in ("Makefile", "pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, folder / name)
    change(folder / "config/config.yaml", "scenes", ["folding"])
    change(folder / "config/config.yaml", "seeds", [0])
    runs([sys.executable, "-m", "venv", "--without-pip", str(folder / ".venv")], folder)
    packages = next(folder.glob(".venv/lib/python*/site-packages"))
    (packages / "packages.pth").write_text(f"{Path(pytest.__file__).parents[1]}\n")
    files = FILE.findall(PAGES[page])
    if "config/mine.yaml" not in dict(files):
        files += [("config/mine.yaml", text) for text in overlays(page)[:1]]
    for name, text in files:
        assert not (folder / name).exists(), f"{name} is there already"
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_text(text.replace("/path/to/vibrom", str(folder)))
    return folder


def together() -> list[list[str]]:
    """Pages that ask for files are followed each alone, all others in one copy."""
    asking = [[page] for page in PAGES if FILE.search(PAGES[page]) or overlays(page)]
    return [*asking, [page for page in PAGES if [page] not in asking]]


@pytest.mark.parametrize("page", [page for page in PAGES if page.endswith(".md")])
def test_commands_stand_in_blocks_that_are_read(page):
    languages = {language for language, _ in FENCED.findall(PAGES[page])}
    assert languages <= {"sh", "python", "py", "yaml"}


@pytest.mark.parametrize("pages", together(), ids=lambda pages: Path(pages[0]).stem)
def test_every_command_of_a_page_is_run(tmp_path, pages):
    folder, done = checkout(tmp_path / "checkout", pages[0]), set()
    for page, block in [(name, block) for name in pages for block in shown(name, RUN)]:
        place = folder
        for line in block:
            words = shlex.split(line.replace("/path/to/vibrom", str(folder)))
            if words[0] == "cd":
                place = place / words[1]
            elif (line, place) not in done:
                assert words[0] in RUN, f"{page} shows `{line}`; nothing here runs {words[0]}"
                RUN[words[0]](words, place)
            done.add((line, place))
