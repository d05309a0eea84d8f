"""The whole workflow in miniature: settings of tests/workflow/small_dag.yaml."""

import re

from project_copy import ROOT, command, copy, plan

SEEDED = ("split", "split_plus")
FITTED_ONCE = ("ssmlearn", "ssmlearn_11", "pysindy_modal", "equations")
EXPERIMENTS = ("reconstruction", "decay", "backbone", "forced", "frc", "eigenvalues", "run_times")
EXPERIMENTS += ("branches", "s_curve", "resonance", "sweeps", "response")


class Run:
    """A copy of the repository whose package can be edited."""

    def __init__(self, folder):
        self.folder = copy(folder, "src")
        self.results = self.folder / "results"

    def snakemake(self, *arguments, overlays=(), start=command):
        overlay = ROOT / "tests/workflow/small_dag.yaml"
        given = (*arguments, "--configfile", str(overlay), *overlays)
        return start(self.folder, *given, PYTHONPATH=str(self.folder / "src"))

    def plan(self, *arguments: str, overlays=()) -> str:
        """What a dry run says."""
        given = (*arguments, "--dry-run", "--quiet", "rules")
        said = self.snakemake(*given, overlays=overlays, start=plan)
        assert said.returncode == 0, said.stdout + said.stderr
        return said.stdout + said.stderr

    def planned(self, *arguments: str, overlays=()) -> dict[str, int]:
        """Rule -> number of jobs that a run would start."""
        table = self.plan(*arguments, overlays=overlays).partition("Job stats:")[2]
        found = re.findall(r"^(\w+) +(\d+)$", table.partition("total")[0], re.MULTILINE)
        return {name: int(count) for name, count in found}

    def contents(self) -> dict:
        return {path: path.read_bytes() for path in self.results.rglob("*.nc")}
