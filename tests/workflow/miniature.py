"""The whole workflow in miniature: settings of tests/workflow/small_dag.yaml."""

import re

from project_copy import ROOT, command, copy


class Run:
    """A copy of the repository whose package can be edited."""

    def __init__(self, folder):
        self.folder = copy(folder, "src")
        self.results = self.folder / "results"

    def snakemake(self, *arguments, overlays=()):
        overlay = ROOT / "tests/workflow/small_dag.yaml"
        return command(
            self.folder,
            *arguments,
            "--configfile",
            str(overlay),
            *overlays,
            PYTHONPATH=str(self.folder / "src"),
        )

    def planned(self, *arguments: str, overlays=()) -> dict[str, int]:
        """Rule -> number of jobs that a run would start."""
        plan = self.snakemake(*arguments, "--dry-run", "--quiet", "rules", overlays=overlays)
        assert plan.returncode == 0, plan.stdout + plan.stderr
        table = (plan.stdout + plan.stderr).partition("Job stats:")[2].partition("total")[0]
        return {
            name: int(count) for name, count in re.findall(r"^(\w+) +(\d+)$", table, re.MULTILINE)
        }

    def contents(self) -> dict:
        return {path: path.read_bytes() for path in self.results.rglob("*.nc")}
