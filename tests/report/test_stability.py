"""Tables and figures of hard cases: counts, intervals and medians by hand, gaps in words, all
formats.
"""

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from vibrom.artefacts.data import label, save_dataset, variable
from vibrom.report import names, stability, tables
from vibrom.report.collection import Collection
from vibrom.report.figures import draw
from vibrom.report.scores import COLUMNS, Scores
from vibrom.steps import tables as tables_step
from vibrom.steps._files import collection as opened
from vibrom.steps.stability import Results
from vibrom.studies import grid

CASES = grid.cases([1.0, 2.0], np.linspace(0.9, 1.1, 3), 2, 1.3)  # ten runs
TRUTH = np.array([1.0, 2.0, 4.0, 2.0, 1.0])


def answer(lost: int, curve, nmte: float) -> xr.Dataset:
    """A seed that lost so many of its ten runs without a guard and none with one."""
    results = Results(["none", "bounded"], ["tight", "loose"], CASES, np.arange(5.0))
    for place in ((0, 0), (1, 0), (0, 1)):
        results.outcome[place] = "ok"
        results.outcome[place][-1] = "left_range"
        results.range_ratio[place], results.frc_amplitude[place], results.frc_outcome[place] = (
            1.2,
            TRUTH,
            "ok",
        )
        results.decay_nmte[place] = results.forced_nmte[place] = 1.0
        results.real_part[place] = -4.0
    results.outcome[0, 0, :lost], results.failed_at[0, 0, :lost] = (
        "diverged",
        np.arange(1, lost + 1),
    )
    results.frc_amplitude[0, 0], results.decay_nmte[0, 0] = curve, nmte
    results.energy[:], results.envelope[:] = np.exp(-np.arange(50.0)), np.exp(-np.arange(50.0) / 2)
    results.energy[0, 0, 3] = 1.0
    return results.dataset()


@pytest.fixture(scope="module")
def collection(tmp_path_factory):
    root, paths = tmp_path_factory.mktemp("hard") / "results", []

    def save(dataset, kind, model, seed=None):
        folder = root / "folding" / model / (f"seed_{seed}" if seed is not None else "")
        save_dataset(
            label(dataset, kind, scene="folding", method=model, seed=seed), folder / f"{kind}.nc"
        )
        paths.append(str(folder / f"{kind}.nc"))

    frequency = variable("angular_frequency", np.arange(5.0), "rad/s", "frequency")
    save(
        xr.Dataset(
            {
                "amplitude": variable(
                    ("probe", "angular_frequency"), TRUTH[None], "m", "amplitude"
                ),
                "phase": variable((), 0.0, "rad", "phase"),
                "outcome": variable((), "ok", "1", "outcome"),
                "failed_at": variable((), np.nan, "s", "failed"),
            },
            coords={"angular_frequency": frequency},
        ),
        "frc",
        "full_order",
    )
    dims, shape = ("steps_per_period", "alpha", "forcing"), (2, 1, 2)
    ended = np.full((*shape, 5), "ok", dtype=object)
    ended[0, :, :, 2] = "no_convergence"
    save(
        xr.Dataset(
            {
                "outcome": variable((*dims, "angular_frequency"), ended, "1", "outcome"),
                "failed_at": variable(
                    (*dims, "angular_frequency"),
                    np.where(ended == "ok", np.nan, 7.0),
                    "1",
                    "failed",
                ),
                "amplitude": variable(
                    (*dims, "angular_frequency"),
                    np.where(ended == "ok", 0.9 * TRUTH, np.nan),
                    "m",
                    "amplitude",
                ),
                "reference": variable("angular_frequency", TRUTH, "m", "truth"),
                "seconds": variable(dims, np.ones(shape), "s", "seconds"),
            },
            coords={
                "steps_per_period": variable("steps_per_period", [20, 100], "1", "steps"),
                "alpha": variable("alpha", [0.05], "1", "alpha"),
                "forcing": variable("forcing", [1.0, 2.0], "1", "forcing"),
                "angular_frequency": frequency,
            },
        ),
        "stability",
        "full_order",
    )
    save(answer(3, TRUTH * [1.01, 1.02, np.nan, 0.97, 1.0], np.nan), "stability", "split", 0)
    save(answer(1, TRUTH * [1.01, 1.02, 1.1, 0.97, 1.0], 2.0), "stability", "split", 1)
    save(answer(0, np.roll(TRUTH, 1) * 0.9, 4.0), "stability", "split", 2)
    return opened(paths)


def only(frame, guard, integrator):
    found = frame[(frame["guard"] == guard) & (frame["integrator"] == integrator)]
    assert len(found) == 1
    return found.iloc[0]


def test_outcomes_are_counted_with_wilson_intervals(collection):
    frame = stability.outcomes(collection)
    assert list(zip(frame["guard"], frame["integrator"])) == [
        ("none", "tight"),
        ("none", "loose"),
        ("bounded", "tight"),
    ]  # one pair was not asked
    plain = only(frame, "none", "tight")
    assert (
        plain["runs"],
        plain["diverged"],
        plain["left_range"],
        plain["ok"],
        plain["not_asked"],
    ) == (30, 4, 3, 23, 0)
    assert plain["median_failure_periods"] == pytest.approx(1.5)  # of 1, 2, 3 and 1
    # 26 of 30 by Wilson's formula, z = 1.959964: centre (p + z^2/2n)/(1 + z^2/n), half width z
    # sqrt(p(1-p)/n + z^2/4n^2)/(1 + z^2/n).
    p, n, z2 = 26 / 30, 30, 1.959964**2
    centre, half = (
        (p + z2 / (2 * n)) / (1 + z2 / n),
        np.sqrt(z2 * (p * (1 - p) / n + z2 / (4 * n**2))) / (1 + z2 / n),
    )
    assert plain["held_percent"] == pytest.approx(100 * p)
    assert (plain["held_low_percent"], plain["held_high_percent"]) == pytest.approx(
        (100 * (centre - half), 100 * (centre + half)), rel=1e-6
    )
    assert only(frame, "bounded", "tight")["held_percent"] == 100.0


def test_guards_are_compared_by_medians_over_seeds(collection):
    plain, bounded = (
        only(stability.guards(collection), guard, "tight") for guard in ("none", "bounded")
    )
    assert (plain["points"], plain["points_with_value"]) == (15, 14)
    # Medians of the seeds: of 1, 2, failed, 3, 0: 2; of 1, 2, 10, 3, 0: 2; of the shifted curve 10,
    # 55, 55, 80, 80: 55.
    assert plain["median_amplitude_error_percent"] == pytest.approx(2.0) and plain[
        "median_amplitude_error_percent_max"
    ] == pytest.approx(55.0)
    # The curve with a gap has no peak; the others are 10 % too high and 10 % too low, in place and
    # one frequency off.
    assert plain["peak_error_percent"] == pytest.approx(0.0) and (
        plain["peak_error_percent_min"],
        plain["peak_error_percent_max"],
    ) == pytest.approx((-10.0, 10.0))
    assert plain["peak_steps"] == pytest.approx(0.5)
    assert plain["decay_nmte_percent"] == pytest.approx(4.0) and np.isnan(
        plain["decay_nmte_percent_max"]
    )  # of failed, 2 and 4
    assert (plain["decays"], plain["energy_rises"], plain["envelope_rises"]) == (6, 3, 0)
    assert (
        bounded["median_amplitude_error_percent"],
        bounded["peak_error_percent"],
        bounded["energy_rises"],
    ) == (0.0, 0.0, 0)
    assert plain["outcome"] == "ok"


def test_full_order_at_coarse_steps(collection):
    frame = stability.full_order(collection)
    assert list(frame["points_with_value"]) == [4, 4, 5, 5] and list(
        frame["median_failure_periods"]
    )[:2] == [7.0, 7.0]
    whole = frame[(frame["steps_per_period"] == 100) & (frame["forcing"] == 1.0)].iloc[0]
    assert (
        whole["median_amplitude_error_percent"] == pytest.approx(10.0)
        and whole["peak_error_percent"] == pytest.approx(-10.0)
        and whole["gamma"] == 0.55
    )
    assert (
        frame.loc[frame["forcing"] == 2.0, "median_amplitude_error_percent"].isna().all()
    )  # nothing to compare with


def test_all_are_written_and_drawn_and_a_run_without_them_is_no_error(collection, tmp_path):
    nobody = Scores(pd.DataFrame(columns=COLUMNS))
    paths = [
        str(tmp_path / f"{name}.{form}")
        for name in names.tables("stability")
        for form in names.TABLE_FORMATS
    ]
    tables_step.run(
        artefacts=[loader.args[0] for loader in collection.loaders.values()], tables=paths
    )
    assert (
        "no_convergence 1" in (tmp_path / "full_order_steps.html").read_text()
        and r"$\gamma$" in (tmp_path / "full_order_steps.tex").read_text()
    )
    for name in names.figures(["folding"], "stability"):
        figure = draw(name, collection, nobody)
        assert all(
            axes.get_xlabel() or axes.get_title(loc="left") or axes.get_label() == "<colorbar>"
            for axes in figure.axes
        )
        assert names.split(name)[1] == "folding"
    assert "none: 4 of 18 failed" in " ".join(
        axes.get_title(loc="left")
        for axes in draw("stability_map_folding", collection, nobody).axes
    )
    empty = opened([])
    assert all(tables.build(name, empty, nobody).empty for name in names.tables("stability"))


def test_a_guard_that_does_not_suit_a_model_is_no_failure_of_it(collection):
    """Nothing was asked, so nothing held and nothing was lost."""

    def skipped(answer):
        answer["outcome"].values[1, 0] = answer["frc_outcome"].values[1, 0] = "skipped"
        answer["energy"].values[1], answer["envelope"].values[1] = np.nan, np.nan
        return answer

    whole = {
        key: load
        for key, load in collection.loaders.items()
        if key[1] == "full_order" or key[2] == "seed_2"
    }
    alone = Collection(
        {
            key: (lambda load=load: skipped(load().load())) if key[1] == "split" else load
            for key, load in whole.items()
        }
    )
    row = only(stability.outcomes(alone), "bounded", "tight")
    assert (row["runs"], row["not_asked"], row["outcome"]) == (0, 10, "skipped")
    assert np.isnan([row["held_percent"], row["held_low_percent"], row["held_high_percent"]]).all()
    row = only(stability.guards(alone), "bounded", "tight")
    assert row["decays"] == 0 and np.isnan(row["energy_rises"]) and row["outcome"] == "skipped"
    words = {
        text.get_text()
        for axes in draw(
            "stability_map_folding", alone, Scores(pd.DataFrame(columns=list(COLUMNS)))
        ).axes
        for text in axes.texts
    }
    assert words == {"skipped"}
