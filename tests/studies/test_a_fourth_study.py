"""A study more is three files and a block of the configuration: the study, a table, a figure."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pandas as pd
import pytest
import two_dof_case
import two_dofs
import yaml
from project_copy import copy, plan

from vibrom.artefacts.data import save_dataset
from vibrom.config.settings import load

ROOT = Path(__file__).parents[2]
STUDY = '''
"""Tolerances: what the integrator of a fitted model is worth."""

from dataclasses import dataclass, replace

import numpy as np
import xarray as xr

from vibrom.artefacts.data import variable
from vibrom.config.kinds import Several, Tolerance
from vibrom.models.reduced import Reduced
from vibrom.models.rollout import Integrator
from vibrom.models.rom import rom_from_dataset
from vibrom.studies import Case, Study
from vibrom.studies.parts.records import Column, stacked

COLUMNS = {
    "nmte": Column("percent", "NMTE of the decay"),
    "outcome": Column("1", "how the decay ended", missing="not_run"),
}


@dataclass(frozen=True)
class Tolerances(Study):
    """The decay is evaluated with each."""

    rtol: Several[Tolerance]  # of the integrator

    jobs = {"model": "tolerances"}
    reads = {"model": ("full_order/test",)}
    experiments = ("decay",)

    def of_model(self, case: Case) -> xr.Dataset:
        """One entry a tolerance."""
        (fitted,) = case.fitted
        records, question = [], case.question("decay")
        for rtol in self.rtol:
            integrator = Integrator(**{**case.integrator, "rtol": rtol})
            model = Reduced.of_scene(rom_from_dataset(fitted.record), case.structure, integrator)
            answer = question.ask(model, case.given)
            error = question.score(answer, case.truth("decay"))["nmte_percent"]
            records.append({"nmte": error, "outcome": answer["outcome"].item()})
        return xr.Dataset(
            stacked(records, {"rtol": len(records)}, COLUMNS, {}),
            coords={"rtol": variable("rtol", np.array(self.rtol), "1", "relative tolerance")},
        )
'''
TABLE = '''
"""Tolerances of the integrator

Decays with each of them.
"""

from vibrom.artefacts.outcome import Outcome
from vibrom.report.columns import CASE, METHOD, OUTCOME, Column

FAMILY = "tolerances"
PLACE = 900
COLUMNS = (CASE, METHOD, Column("rtol", "rtol [–]"), Column("nmte_percent", "NMTE [%]"), OUTCOME)


def build(collection, scores):
    """One row a model and tolerance."""
    rows = []
    for scene in collection.scenes:
        for method in collection.methods:
            for answer in collection.every(scene, method, "tolerances"):
                for rtol in answer["rtol"].values:
                    one = answer.sel(rtol=rtol)
                    rows.append({"case": scene, "method": method, "rtol": float(rtol)})
                    rows[-1] |= {"nmte_percent": float(one["nmte"])}
                    rows[-1] |= {"outcome": Outcome(str(one["outcome"].item()))}
    return rows
'''
FIGURE = '''
"""Tolerances of the integrator

Error of decays.
"""

from matplotlib.figure import Figure

FAMILY = "tolerances"
PLACE = 900
EACH = "run"
DATA = ("tolerances",)


def draw(collection, scores, scene=None) -> Figure:
    """A line a model."""
    figure = Figure(figsize=(4, 3))
    panel = figure.subplots()
    for method in collection.methods:
        for answer in collection.every("two", method, "tolerances"):
            panel.loglog(answer["rtol"], answer["nmte"], "o-", label=method)
    panel.set(xlabel="relative tolerance [–]", ylabel="NMTE [%]")
    return figure
'''
FILES = {
    "studies/tolerances.py": STUDY,
    "report/tables/tolerances.py": TABLE,
    "report/figures/tolerances.py": FIGURE,
}
RUN = """
import json, sys
from vibrom.steps import output, study

given = json.loads(sys.argv[1])
study.run(**given["study"], provenance={})
for made in given["outputs"]:
    output.run(**made, provenance={"source_digest": "0"})
"""


@pytest.fixture(scope="module")
def project(tmp_path_factory):
    """A copy with the three files, and an overlay with the study's block."""
    folder = copy(tmp_path_factory.mktemp("project"), "src")
    for name, text in FILES.items():
        (folder / "src/vibrom" / name).write_text(text.lstrip())
    block = {"scenes": ["folding"], "rtol": [1e-2, 1e-4, 1e-8]}
    (folder / "more.yaml").write_text(yaml.safe_dump({"studies": {"tolerances": block}}))
    return folder


def test_its_jobs_table_and_figure_are_planned(project):
    found = plan(
        project,
        *("tolerances", "--dry-run", "--quiet", "rules", "--configfile", "more.yaml"),
        PYTHONPATH=str(project / "src"),
    )
    text = found.stdout + found.stderr
    jobs = dict(re.findall(r"^(\w+) +(\d+)$", text.partition("Job stats:")[2], re.MULTILINE))
    settings = load(ROOT / "config")
    fits = [folder for method in settings.methods for folder in settings.seed_folders(method)]
    assert jobs["tolerances_model"] == str(len(fits)), text
    assert jobs["tolerances_tables"] == jobs["tolerances_figures"] == "1"
    assert "robustness_model" not in jobs and "frc" not in jobs


def test_its_step_table_and_figure_are_made(project, tmp_path):
    """Of an exact model a tighter tolerance leaves less error."""
    case = two_dof_case.case()
    artefacts = {
        "structure": case.structure,
        "test": case.full_order["test"],
        "rom": two_dof_case.fit(two_dofs.rom(), "modal_projection"),
    }
    for name, dataset in artefacts.items():
        save_dataset(dataset, tmp_path / f"{name}.nc")
    paths = {name: str(tmp_path / f"{name}.nc") for name in (*artefacts, "tolerances")}
    given = {
        "study": {
            "output": paths["tolerances"],
            "study": {"name": "tolerances", "kind": "model", "settings": {"rtol": [1e-2, 1e-6]}},
            "names": {"scene": "two", "method": "modal_projection", "seed": None},
            "case": {"scene": case.scene, "integrator": case.integrator},
            "structure": paths["structure"],
            "full_order": [paths["test"]],
            "fitted": [paths["rom"]],
        },
        "outputs": [
            {
                "kind": kind,
                "artefacts": [paths["tolerances"]],
                "outputs": [str(tmp_path / f"tolerances.{form}")],
            }
            for kind, form in (("tables", "csv"), ("figures", "svg"))
        ],
    }
    done = subprocess.run(
        [sys.executable, "-c", RUN, json.dumps(given)],
        env={**os.environ, "PYTHONPATH": str(project / "src")},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    table = pd.read_csv(tmp_path / "tolerances.csv", comment="#")
    assert table["rtol"].tolist() == [1e-2, 1e-6] and set(table["outcome"]) == {"ok"}
    assert table["nmte_percent"][0] > 100 * table["nmte_percent"][1]
    assert "NMTE" in (tmp_path / "tolerances.svg").read_text()
