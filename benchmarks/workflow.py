"""Where the time of the main job goes.

Seconds of every rule from Snakemake's benchmark files in `results/benchmarks`, as the last main job
left them: run `make` first. The wall time is from the start of the first job to the end of the
last. Timed here: planning the whole graph again (`snakemake --dry-run`), planning one of more than
2000 jobs, as of a run with many seeds, and what Snakemake adds to a job.
"""

import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import matplotlib.pyplot as plt
import pandas as pd

from benchmarks.table import Row, paired

FOLDER = Path("results/benchmarks")
SNAKEMAKE = str(Path(sys.executable).with_name("snakemake"))
SEEDS = 36
NOTHING = """
rule all:
    input: [f"{k}.txt" for k in range(config["count"])]
rule nothing:
    output: "{k}.txt"
    script: "nothing.py"
"""


def jobs() -> pd.DataFrame:
    """One row a job: rule, model, wall and processor seconds, when it ended."""
    found = []
    for path in FOLDER.rglob("*.tsv"):
        table, place = pd.read_csv(path, sep="\t"), path.relative_to(FOLDER).parts
        kind = "full order" if "full_order" in place else place[1] if len(place) > 2 else "report"
        found.append(
            {
                "rule": path.stem,
                "model": kind,
                "seconds": float(table["s"][0]),
                "processor": pd.to_numeric(table["cpu_time"], errors="coerce")[0],
                "end": path.stat().st_mtime,
            }
        )
    return pd.DataFrame(found)


def measure(note) -> Iterator[Row]:
    done, rows = jobs(), []
    if len(done):
        yield Row(
            "workflow",
            f"main job, {len(done)} timed jobs, wall time",
            done["end"].max() - (done["end"] - done["seconds"]).min(),
            "s",
        )
        for (model, rule), group in done.groupby(["model", "rule"]):
            seconds = group["seconds"].sum()
            text = f"{model}: {rule}, {len(group)} jobs"
            rows.append(Row("workflow", text, seconds, "s", panel="rules", series=model, at=rule))
        yield from sorted(rows, key=lambda row: -row.value)
    else:
        note("no benchmark files: run the main job first")
    dry = [SNAKEMAKE, "--dry-run", "--quiet", "all"]
    seconds = paired({"dry": lambda: silent(dry)}, repeats=5)
    yield Row("workflow", "dry run of the whole graph", seconds["dry"], "s")
    yield from many()
    yield Row("workflow", "overhead of a job", overhead(), "s")


def silent(line: list[str], folder: str | None = None) -> str:
    run = subprocess.run(line, capture_output=True, check=True, text=True, cwd=folder)
    return run.stdout + run.stderr


def many() -> Iterator[Row]:
    """Planning a graph of some thousand jobs, from nothing."""
    with tempfile.TemporaryDirectory() as folder:
        overlay = Path(folder, "seeds.yaml")
        overlay.write_text(f"seeds: {list(range(SEEDS))}\n")
        given = ["--directory", folder, "--configfile", str(overlay)]
        began = time.perf_counter()
        printed = silent([SNAKEMAKE, "--dry-run", "--quiet", "rules", *given])
        seconds = time.perf_counter() - began
    jobs = int(re.search(r"^total +(\d+)$", printed, re.MULTILINE)[1])
    yield Row("workflow", f"dry run of {jobs} jobs", seconds, "s")
    yield Row("workflow", f"dry run of {jobs} jobs, a job", 1e3 * seconds / jobs, "ms")


def overhead() -> float:
    """Of a job whose script does nothing [s]: 50 jobs one by one, less the run of one."""
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "nothing.py").write_text("open(snakemake.output[0], 'w').close()\n")
        Path(folder, "Snakefile").write_text(NOTHING)
        spent = []
        for count in (1, 51):
            began = time.perf_counter()
            silent([SNAKEMAKE, "--cores", "1", "--config", f"count={count}"], folder)
            spent.append(time.perf_counter() - began)
    return (spent[1] - spent[0]) / 49  # 50 jobs in the second run, one in the first


def figures(rows: pd.DataFrame) -> dict:
    some = rows[rows["panel"] == "rules"]
    if some.empty:
        return {}
    table = some.pivot_table(index="at", columns="series", values="value", aggfunc="sum")
    table = table.fillna(0.0)
    table = table.loc[table.sum(axis=1).sort_values().index]
    figure, axis = plt.subplots(figsize=(7.2, 0.2 * len(table) + 0.8))
    left = pd.Series(0.0, index=table.index)
    for number, model in enumerate(table.columns):
        axis.barh(
            table.index,
            table[model],
            left=left,
            color=plt.get_cmap("tab10")(number % 10),
            label=model,
        )
        left += table[model]
    axis.set(xlabel="seconds, all jobs of a rule")
    axis.legend(loc="lower right")
    return {"where_the_time_goes": figure}
