"""The whole workflow in miniature: all is made, and says what it is."""

import json
import re

import numpy as np
import pytest
import xarray as xr
from miniature import EXPERIMENTS, FITTED_ONCE, SEEDED
from project_copy import RUNS
from rocrate.rocrate import ROCrate
from warm_jobs import PEAKS

from vibrom.artefacts.data import KINDS, open_dataset
from vibrom.config import plugs
from vibrom.config.memory import HELD
from vibrom.report import outputs


def test_the_run_says_what_was_made_from_what(small):
    described = ROCrate(str(small.results))
    action = described.get("#made/folding/split/seed_0/decay.nc")
    files = {one.id for one in action["object"] if one.type == "File"}
    own = {"folding/split/seed_0/rom.nc", "folding/full_order/structure.nc"}
    assert own | {"folding/full_order/test.nc"} <= files
    (settings,) = (one for one in action["object"] if one.type == "PropertyValue")
    assert json.loads(settings["value"])["integrator"]["rtol"] == 1e-4
    every = {str(path.relative_to(small.results)) for path in small.contents()}
    kept = {name for name in every if not name.startswith("mlflow_artifacts")}
    assert kept <= {entity.id for entity in described.data_entities}


def test_every_artefact_is_there_and_says_what_made_it(small):
    folders = [f"{method}/seed_0" for method in SEEDED] + [
        f"{method}/unseeded" for method in FITTED_ONCE
    ]
    for folder in folders:
        for name in ("rom", "losses", *EXPERIMENTS, "robustness"):
            data = open_dataset(small.results / "folding" / folder / f"{name}.nc", name)
            assert data.attrs["scene"] == "folding" and data.attrs["method"] == folder.split("/")[0]
            assert len(data.attrs["source_digest"]) == 16 and "python" in json.loads(
                data.attrs["versions"]
            )
    for path in (small.results / "folding/full_order").glob("*.nc"):
        kind = {"train": "trajectory", "test": "trajectory"}.get(path.stem, path.stem)
        assert kind in {*KINDS, *EXPERIMENTS, *plugs.names("studies")}
        open_dataset(path, kind)


def test_units_are_written_so_that_programs_read_them(small):
    """As UDUNITS does, whose exponents are whole. It takes kg0.5 for half of something, and refuses
    kg^(1/2), which pint and astropy read.
    """
    part = r"[A-Za-z]+(-?[1-9]|\^\(-?1/2\))?"
    found = set()
    for path in (small.results / "folding").rglob("*.nc"):
        with xr.open_dataset(path) as data:
            found |= {one.attrs["units"] for one in data.variables.values()}
    assert {"m", "rad s-1", "kg^(1/2)"} <= found
    assert not {unit for unit in found if not re.fullmatch(f"1|{part}( {part})*", unit)}


def test_every_table_figure_and_page_is_there(small):
    wanted = []
    for family in outputs.families():
        made = {
            "tables": outputs.tables(family, EXPERIMENTS),
            "figures": outputs.figures(family, ["folding"], asked=lambda scene: EXPERIMENTS),
        }
        for kind, forms in outputs.FORMATS.items():
            wanted += [f"{kind}/{name}.{form}" for name in made[kind] for form in forms]
    for name in (*wanted, "scores.csv", "report.html", "mlflow.db", "headline.txt"):
        assert (small.results / name).stat().st_size > 0, name
    there = [path for kind in outputs.FORMATS for path in (small.results / kind).iterdir()]
    assert {f"{path.parent.name}/{path.name}" for path in there} == set(wanted)  # and no others


def test_the_study_of_costs_agrees_with_the_experiments(small):
    study = open_dataset(small.results / "folding/full_order/cost_reduced.nc", "cost_reduced")
    model, varied, value = (study[name].values for name in ("model", "varied", "value"))

    def at(method, what="as configured", to=""):
        (index,) = np.flatnonzero((model == method) & (varied == what) & (value == to))
        return study.isel(setting=index)

    scores = {
        "decay": "nmte_percent",
        "forced": "nmte_percent",
        "frc": "amplitude_error_median_percent",
    }
    for folder in [f"{method}/seed_0" for method in SEEDED] + [
        f"{method}/unseeded" for method in FITTED_ONCE
    ]:
        row = at(folder.split("/")[0])
        for question, score in scores.items():
            answer = open_dataset(small.results / "folding" / folder / f"{question}.nc", question)
            np.testing.assert_array_equal(
                row["error"].sel(question=question), answer["score_value"].sel(score=score)
            )
    # A fit with the settings that it has anyway is the same model.
    np.testing.assert_array_equal(
        at("ssmlearn", "order_decoder, order_dynamics", "3")["error"], at("ssmlearn")["error"]
    )
    train = open_dataset(small.results / "folding/full_order/train.nc", "trajectory")
    share = 2 * float(train["period"]) / float(train["time"][-1] - train["time"][0])
    assert float(at("ssmlearn_11", "periods", "2")["data_seconds"]) == pytest.approx(
        share * float(train["seconds"])
    )
    # A tolerance needs no new fit; a start that is trained again does.
    usual, loose, short = (
        at("split_plus"),
        at("split_plus", "rtol", "0.001"),
        at("split_plus", "start.epochs", "1"),
    )
    assert (
        float(loose["mapping_seconds"])
        == float(usual["mapping_seconds"])
        != float(short["mapping_seconds"])
    )
    assert not np.array_equal(short["error"], usual["error"])


def test_the_run_ends_with_the_headline(small):
    headline = (small.results / "headline.txt").read_text().splitlines()[0]
    assert headline in small.answer.stdout


def test_no_job_takes_more_memory_than_its_rule_asks_for(small):
    """This scene is small: what programs take, and here besides what others import."""
    lines = (small.folder / PEAKS).read_text().splitlines()
    assert len(lines) > 40
    for rule, peak in map(str.split, lines):  # MB
        kind = "full_order" if rule in ("structure", "release", "record") else "fit"
        assert 100.0 < float(peak) < HELD[kind][0], rule


def test_another_run_of_the_same_has_the_same_bytes_but_for_wall_times(small):
    """That of the walks of docs/, which asks for some of the same artefacts."""
    if "docs" not in RUNS:
        pytest.skip("test_docs.py, whose run is compared, has not run in this session")
    compared = []
    for path in sorted((RUNS["docs"] / "results/folding").rglob("*.nc")):
        other = small.results / path.relative_to(RUNS["docs"] / "results")
        if not other.exists() or path.stem == "run_times":  # times are its answer
            continue
        with xr.open_dataset(path) as mine, xr.open_dataset(other) as theirs:
            if mine.attrs["asked"] != theirs.attrs["asked"]:
                continue
            compared.append(f"{path.parent.name}/{path.stem}")
            assert mine.variables.keys() == theirs.variables.keys(), path
            for name in mine.variables:
                if "wall time" not in mine[name].attrs["long_name"]:
                    assert mine[name].identical(theirs[name]), (path, name)
    full_order = {f"full_order/{name}" for name in ("structure", "release", "train", "test", "frc")}
    assert {*full_order, "unseeded/rom", "unseeded/losses"} <= {*compared}
