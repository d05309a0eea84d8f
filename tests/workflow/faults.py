"""Faults in a small run, one after the other: `python tests/workflow/faults.py [rounds [targets]]`.

With the targets `scores tables` all that is compared is made, and no figures, report and store.

In each round something is spoilt: the run or one of its jobs is killed, the disk is full, artefacts
are damaged or change places, the clock goes back, two runs start at once. Then the same command
must end well, by itself or after what its one line asks for, and all tables that hold no time must
be those of an undisturbed run.
"""

import csv
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

import psutil
from project_copy import LIMIT, ROOT, copy

OVERLAYS = [str(ROOT / f"tests/workflow/{name}.yaml") for name in ("small_dag", "faults")]
TIMES = re.compile(r"second|_s$|speed|run_time|ratio|core_hours")  # columns that differ every time
DELETE = re.compile(r"vibrom: (\S+\.nc): .*delete it and run again")


class Run:
    """A copy of the workflow, and the command in it."""

    def __init__(self, folder: Path, targets: Sequence[str] = (), overlays: Sequence[str] = ()):
        folder.mkdir(parents=True, exist_ok=True)
        self.folder = copy(folder, "src")
        self.targets, self.overlays = targets, [*OVERLAYS, *overlays]
        self.results = folder / "results"

    @property
    def command(self) -> list[str]:
        program = str(Path(sys.executable).with_name("snakemake"))
        return [program, "--cores", "2", *self.targets, "--configfile", *self.overlays]

    def start(self, **environment: str) -> subprocess.Popen:
        given = os.environ | {"PYTHONPATH": str(self.folder / "src")} | environment
        return subprocess.Popen(
            self.command,
            cwd=self.folder,
            env=given,
            text=True,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )

    def finish(self, **environment: str) -> tuple[int, str]:
        """Return code and all that was printed."""
        process = self.start(**environment)
        printed, _ = process.communicate(timeout=LIMIT)
        return process.returncode, printed

    def artefacts(self) -> list[Path]:
        return sorted(self.results.rglob("*.nc"))

    def tables(self) -> dict[str, list]:
        return tables(self.results)


def tables(results: Path) -> dict[str, list]:
    """The rows of every table, without the columns of times."""
    found = {}
    for path in [*sorted(results.glob("tables/*.csv")), results / "scores.csv"]:
        rows = list(csv.DictReader(path.open(encoding="utf-8", newline="")))
        if path.name == "scores.csv":
            rows = [row for row in rows if row["unit"] != "s"]
        kept = [{key: row[key] for key in row if not TIMES.search(key)} for row in rows]
        if "run_times" not in path.stem:
            found[path.stem] = kept
    return found


def some_results_are_gone(run: Run, chance: random.Random) -> None:
    """So that there is something to be done: what all others lead to is gone too."""
    chosen = [path for path in run.artefacts() if chance.random() < 0.15]
    for path in [*chosen, run.results / "scores.csv", *run.results.glob("tables/*.csv")]:
        path.unlink(missing_ok=True)


def killed(run: Run, chance: random.Random, number: int) -> None:
    """The run gets a signal at some time."""
    some_results_are_gone(run, chance)
    process = run.start()
    time.sleep(chance.uniform(1.0, 8.0))
    process.send_signal(number)
    process.communicate(timeout=LIMIT)


def one_job_killed(run: Run, chance: random.Random) -> None:
    """A job is killed outright, the run goes on and ends with an error."""
    some_results_are_gone(run, chance)
    process = run.start()
    for _ in range(200):
        jobs = psutil.Process(process.pid).children() if process.poll() is None else []
        if jobs:
            chance.choice(jobs).kill()
            break
        time.sleep(0.1)
    process.communicate(timeout=LIMIT)


def full_disk(run: Run, chance: random.Random) -> None:
    """No file may grow beyond some kilobytes: writes fail as they do on a full disk."""
    some_results_are_gone(run, chance)
    blocks = chance.choice([8, 64, 256])  # of 1024 bytes
    subprocess.run(
        ["sh", "-c", f"ulimit -f {blocks}; trap '' XFSZ; exec {' '.join(run.command)}"],
        cwd=run.folder,
        env=os.environ | {"PYTHONPATH": str(run.folder / "src")},
        capture_output=True,
        timeout=LIMIT,
    )


def damaged(run: Run, chance: random.Random) -> None:
    """Some bytes of an artefact are others, or its end is missing; the time stamp may stay."""
    for path in chance.sample(run.artefacts(), 2):
        before, raw = path.stat(), bytearray(path.read_bytes())
        if chance.random() < 0.3:
            raw = raw[: chance.randrange(len(raw))]
        else:
            for _ in range(40):
                raw[chance.randrange(len(raw))] ^= 1 << chance.randrange(8)
        path.write_bytes(raw)
        if chance.random() < 0.5:
            os.utime(path, ns=(before.st_atime_ns, before.st_mtime_ns))
    some_results_are_gone(run, chance)


def swapped(run: Run, chance: random.Random) -> None:
    """Two artefacts of one kind change places; time stamps go along or are new."""
    by_name: dict[str, list[Path]] = {}
    for path in run.artefacts():
        by_name.setdefault(path.name, []).append(path)
    one, two = chance.sample(chance.choice([found for found in by_name.values() if found[1:]]), 2)
    move = chance.choice([shutil.copy, shutil.copy2])
    third = one.with_suffix(".third")
    for source, target in ((one, third), (two, one), (third, two)):
        move(source, target)
    third.unlink()
    some_results_are_gone(run, chance)


def clock_back(run: Run, chance: random.Random) -> None:
    """Some artefacts seem to be from tomorrow."""
    for path in chance.sample(run.artefacts(), 5):
        later = time.time() + chance.uniform(100.0, 86400.0)
        os.utime(path, (later, later))


def two_at_once(run: Run, chance: random.Random) -> None:
    """One of them must do the work, and the other must leave it alone."""
    some_results_are_gone(run, chance)
    first, second = run.start(), run.start()
    for process in (first, second):
        process.communicate(timeout=LIMIT)


def without_records(run: Run, chance: random.Random) -> None:
    """Snakemake's own notes are gone, as in a copied folder."""
    shutil.rmtree(run.folder / ".snakemake/metadata", ignore_errors=True)
    some_results_are_gone(run, chance)


def swapped_without_records(run: Run, chance: random.Random) -> None:
    """Both at once."""
    without_records(run, chance)
    swapped(run, chance)


FAULTS = {
    "kill -9": lambda run, chance: killed(run, chance, signal.SIGKILL),
    "SIGINT": lambda run, chance: killed(run, chance, signal.SIGINT),
    "SIGTERM": lambda run, chance: killed(run, chance, signal.SIGTERM),
    "one job killed": one_job_killed,
    "full disk": full_disk,
    "damaged": damaged,
    "swapped": swapped,
    "clock set back": clock_back,
    "two at once": two_at_once,
    "no records": without_records,
    "swapped, no records": swapped_without_records,
}


def recovered(run: Run) -> str:
    """How the run ended well: by itself, or after what its line asked for; else what it printed."""
    for attempt in range(6):
        code, printed = run.finish()
        if code == 0:
            return "by itself" if attempt == 0 else "as its line says"
        asked = set(DELETE.findall(printed))
        if not asked:
            return printed
        for path in asked:
            (run.folder / path).unlink(missing_ok=True)
    return printed


def rounds(count: int, run: Run, faults: list[str], seed: int = 0) -> Counter:
    """Fault and how the run recovered -> how often; raises where tables differ or it did not."""
    chance, seen = random.Random(seed), Counter()
    code, printed = run.finish()
    assert code == 0, printed[-6000:]
    wanted = run.tables()
    for place in range(count):
        fault = faults[place % len(faults)]
        FAULTS[fault](run, chance)
        how = recovered(run)
        assert how in ("by itself", "as its line says"), f"{fault}: {how[-6000:]}"
        for name, rows in run.tables().items():
            assert rows == wanted[name], f"{fault}: table {name} differs"
        assert not list(run.results.rglob("*.partial")), f"{fault}: partial files are left"
        seen[fault, how] += 1
        print(f"{place + 1}: {fault}: {how}", flush=True)
    return seen


if __name__ == "__main__":
    COUNT, TARGETS = int([*sys.argv, 100][1]), sys.argv[2:]
    with tempfile.TemporaryDirectory() as SPARE:
        SEEN = rounds(COUNT, Run(Path(SPARE) / "run", TARGETS), list(FAULTS))
    for (FAULT, HOW), TIMES_SEEN in sorted(SEEN.items()):
        print(f"{FAULT}: {TIMES_SEEN} {HOW}")
