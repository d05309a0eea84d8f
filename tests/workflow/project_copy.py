"""A copy of the configuration to spoil, and Snakemake as a command."""

import atexit
import multiprocessing
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import warm_jobs
import yaml

ROOT = Path(__file__).parents[2]
STARTED = multiprocessing.get_context("forkserver")  # a process that has imported Snakemake
STARTED.set_forkserver_preload(["snakemake.cli", "snakemake.report.html_reporter"])
LIMIT = 3600  # s, of one command: it hangs, however busy the machine is
RUNS: dict[str, Path] = {}  # folders of whole runs of this session, which tests may compare


def until(condition: Callable[[], bool]) -> None:
    """Waits for it, however long a busy machine takes."""
    end = time.monotonic() + LIMIT
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.05)


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
        line,
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=LIMIT,
        env=os.environ | environment,
    )


def plan(
    folder: Path, *arguments: str, python: str = sys.executable, **environment: str
) -> subprocess.CompletedProcess:
    """The same command where it runs no job, in a fork of a process that has imported Snakemake:
    that is half of what such a command takes. Jobs would be run by `python`.
    """
    with tempfile.TemporaryDirectory() as spare:
        said = [Path(spare) / name for name in ("out", "err")]
        given = (arguments, folder, os.environ | environment, said, python)
        process = STARTED.Process(target=_main, args=given, daemon=True)
        process.start()
        process.join(LIMIT)
        assert process.exitcode is not None, arguments
        texts = [path.read_text() for path in said]
    return subprocess.CompletedProcess(arguments, process.exitcode, *texts)


@contextmanager
def warm(folder: Path, source: Path | None = None) -> Iterator[Callable]:
    """A command like the others, that runs its jobs as warm_jobs.py says, with the package in
    `source`, or that of the folder; what they took of memory is written there.
    """
    script, place = str(Path(__file__).with_name("warm_jobs.py")), tempfile.mkdtemp()
    there = {warm_jobs.SOCKET: f"{place}/jobs", "PYTHONPATH": str(source or folder / "src")}
    line = [sys.executable, script, there[warm_jobs.SOCKET], str(folder / warm_jobs.PEAKS)]
    server = subprocess.Popen(line, env=os.environ | there, stdout=subprocess.PIPE)
    try:
        assert server.stdout.readline() == b"ready\n"
        python = f"{sys.executable} -S {script}"
        yield lambda folder, *words, **more: plan(folder, *words, python=python, **there | more)
    finally:
        server.kill()
        server.communicate()
        shutil.rmtree(place)


def _main(
    arguments: tuple[str, ...], folder: Path, environment: dict, said: list[Path], python: str
) -> None:
    """Snakemake, in a process of its own."""
    from snakemake.cli import main

    sys.executable = python

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
