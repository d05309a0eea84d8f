"""A copy of the configuration to spoil, and Snakemake as a command."""

import atexit
import multiprocessing
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import yaml

ROOT = Path(__file__).parents[2]
STARTED = multiprocessing.get_context("forkserver")  # a process that has imported Snakemake
STARTED.set_forkserver_preload(["snakemake.cli", "snakemake.report.html_reporter"])
RUNS: dict[str, Path] = {}  # folders of whole runs of this session, which tests may compare


def change(file: Path, key: str, value) -> None:
    """Set one entry of a YAML file, by its dotted key; a value of `...` removes it."""
    content = yaml.safe_load(file.read_text())
    *above, last = key.split(".")
    block = content
    for name in above:
        block = block[name]
    if value is ...:
        del block[last]
    else:
        block[last] = value
    file.write_text(yaml.safe_dump(content, sort_keys=False))


def copy(folder: Path, *names: str) -> Path:
    """The configuration, the rules and the profile of the repository, free to edit, and what else
    is named. Code that was compiled for one copy serves them all.
    """
    for name in ("config", "workflow", "profiles", "envs", *names):
        shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(ROOT / "Snakefile", folder)
    for file in (folder / "src").rglob("*.py"):
        compiled = file.parent / "__pycache__"
        if not compiled.exists():
            there = ROOT / compiled.relative_to(folder)
            there.mkdir(exist_ok=True)
            compiled.symlink_to(there)
    return folder


def command(folder: Path, *arguments: str, **environment: str) -> subprocess.CompletedProcess:
    """The command that the README names, in a folder."""
    line = [str(Path(sys.executable).with_name("snakemake")), *arguments]
    return subprocess.run(
        line, cwd=folder, capture_output=True, text=True, timeout=900, env=os.environ | environment
    )


def plan(folder: Path, *arguments: str, **environment: str) -> subprocess.CompletedProcess:
    """The same command where it runs no job, in a fork of a process that has imported Snakemake:
    that is half of what such a command takes.
    """
    with tempfile.TemporaryDirectory() as spare:
        said = [Path(spare) / name for name in ("out", "err")]
        given = (arguments, folder, os.environ | environment, said)
        process = STARTED.Process(target=_main, args=given, daemon=True)
        process.start()
        process.join(900)
        assert process.exitcode is not None, arguments
        texts = [path.read_text() for path in said]
    return subprocess.CompletedProcess(arguments, process.exitcode, *texts)


def _main(arguments: tuple[str, ...], folder: Path, environment: dict, said: list[Path]) -> None:
    """Snakemake, in a process of its own."""
    from snakemake.cli import main

    for stream, path in zip((1, 2), said, strict=True):
        os.dup2(os.open(path, os.O_WRONLY | os.O_CREAT), stream)
    os.environ.clear()
    os.environ.update(environment)
    os.chdir(folder)
    sys.path[:0] = [path for path in environment.get("PYTHONPATH", "").split(os.pathsep) if path]
    sys.argv = ["snakemake", *arguments]
    try:
        sys.exit(main())
    finally:
        atexit._run_exitfuncs()
