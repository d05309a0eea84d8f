"""Tables: columns of the contract, medians by hand, failures shown, the thesis's numbers in the
right cells.
"""

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from vibrom.report import curves, names, presentation, tables
from vibrom.steps import tables as step
from vibrom.thesis import published as thesis


@pytest.fixture(scope="module")
def frames(collection, scores):
    return {
        name: tables.build(name, collection, scores)
        for name in names.tables("models", "cost", "effects")
    }


def row(frame, case, method):
    found = frame[(frame["case"] == case) & (frame["method"] == method)]
    assert len(found) == 1, f"{len(found)} rows for {case}, {method}"
    return found.iloc[0]


def test_every_case_has_every_model_and_the_full_order_model_is_called_full_order(frames):
    for name in ("eigenvalues", "reconstruction", "decay", "forced", "run_times"):
        models = ("full_order", "modal_projection", "split", "split_plus")
        expected = [(case, model) for case in ("small", "large") for model in models]
        assert list(zip(frames[name]["case"], frames[name]["method"])) == expected, name
    assert list(frames["beam"]["method"]) == ["full_order"] * 2
    assert set(frames["frc"]["method"]) == {"full_order", "modal_projection", "split", "split_plus"}


@pytest.mark.parametrize("name", ["reconstruction", "decay", "forced"])
def test_error_tables_have_the_columns_of_the_contract(frames, name):
    assert list(frames[name].columns)[:7] == [
        "case",
        "method",
        "nmte_percent",
        "nmte_percent_min",
        "nmte_percent_max",
        "thesis_percent",
        "thesis_outcome",
    ]
    assert "outcome" in frames[name].columns


def test_medians_by_hand(frames):
    split = row(frames["decay"], "small", "split")
    assert (split["nmte_percent"], split["nmte_percent_min"], split["nmte_percent_max"]) == (
        3.0,
        1.0,
        8.0,
    )
    assert row(frames["decay"], "small", "split_plus")["nmte_percent"] == 1.5
    assert row(frames["decay"], "large", "modal_projection")["nmte_percent"] == 4.0
    assert row(frames["decay"], "small", "split")["seeds"] == 3
    assert row(frames["decay"], "small", "full_order")["nmte_percent"] == 0.0


def test_failures_are_shown_not_dropped(frames):
    split = row(
        frames["forced"], "large", "split"
    )  # values 3, failed, 8: the failed one counts as infinite
    assert split["nmte_percent"] == pytest.approx(8.0) and split[
        "nmte_percent_min"
    ] == pytest.approx(3.0)
    assert np.isnan(split["nmte_percent_max"]) and split["outcome"] == "ok 2, diverged 1"
    modal = row(frames["forced"], "large", "modal_projection")
    assert np.isnan(modal["nmte_percent"]) and modal["outcome"] == "diverged"
    assert modal["failed_at_s"] == pytest.approx(3 * 2 * np.pi / 400)
    assert row(frames["forced"], "small", "modal_projection")["outcome"] == "ok"
    for name in ("reconstruction", "decay", "forced", "eigenvalues", "run_times"):
        unfit = row(frames[name], "large", "split_plus")
        assert unfit["outcome"] == "ok 1, training_diverged 1", name
        numbers = [column for column in unfit.index if f"{column}_min" in unfit.index]
        assert numbers and all(np.isnan(unfit[column]) for column in numbers), (
            name
        )  # as many seeds failed as did not
    assert np.isnan(row(frames["decay"], "large", "split_plus")["nmte_percent"])
    assert row(frames["decay"], "large", "split_plus")["nmte_percent_min"] == 2.0


def test_thesis_numbers_stand_in_their_cells(frames):
    assert row(frames["decay"], "small", "split")["thesis_percent"] == 0.37445
    assert row(frames["decay"], "large", "split_plus")["thesis_percent"] == 1.4485
    assert row(frames["reconstruction"], "large", "modal_projection")["thesis_percent"] == 2.7082
    assert row(frames["forced"], "large", "modal_projection")["thesis_percent"] == 17.3383
    pair = row(frames["eigenvalues"], "large", "modal_projection")
    assert (pair["thesis_real_per_s"], pair["thesis_imaginary_rad_per_s"]) == (-4.1405, 397.53)
    times = row(frames["run_times"], "small", "split")
    assert (times["thesis_obtain_mapping_s"], times["thesis_frc_s"]) == (5903.2, 48.0)
    assert row(frames["run_times"], "small", "full_order")["thesis_forced_s"] == 8208.4


def test_where_the_thesis_prints_fails_the_table_says_so():
    percent, verdict = thesis.percent("forced", "folding", "ssmlearn")
    assert np.isnan(percent) and verdict == "fails"
    for unknown in (("decay", "small", "pysindy_modal"), ("decay", "my_scene", "split")):
        assert np.isnan(thesis.percent(*unknown)[0])
    values = dict.fromkeys(
        ["nmte_percent", "nmte_percent_min", "nmte_percent_max", "thesis_percent"], [np.nan]
    )
    frame = pd.DataFrame(
        {
            "case": ["folding"],
            "method": ["ssmlearn"],
            **values,
            "thesis_outcome": ["fails"],
            "outcome": ["diverged"],
        }
    )
    printed = presentation.readable("forced", frame)
    assert list(printed["Thesis NMTE [%]"]) == ["fails"] and list(printed["Outcome"]) == [
        "diverged"
    ]


def test_eigenvalues_and_run_times_are_ours(frames):
    pair = row(frames["eigenvalues"], "small", "split")
    assert (pair["real_per_s"], pair["imaginary_rad_per_s"], pair["imaginary_rad_per_s_max"]) == (
        -4.0,
        403.0,
        408.0,
    )
    assert row(frames["eigenvalues"], "small", "full_order")["imaginary_rad_per_s"] == 400.0
    times = row(frames["run_times"], "small", "split")
    assert [times[f"obtain_mapping_s{end}"] for end in ("", "_min", "_max")] == [31.0, 30.0, 32.0]
    assert row(frames["run_times"], "large", "full_order")["decay_s"] == 2.0


def test_response_curves_have_one_row_a_point_with_value_or_outcome(frames):
    frame = frames["frc"]
    assert list(frame.columns) == [
        "case",
        "method",
        "seed",
        "omega_rad_per_s",
        "probe_amplitude_m",
        "tip_amplitude_m",
        "phase_rad",
        "outcome",
        "failed_at_s",
    ]
    assert len(frame) == 2 * 9 * (1 + 1 + 3 + 2)
    lost = frame[frame["probe_amplitude_m"].isna()]
    assert dict(lost["outcome"].value_counts()) == {"training_diverged": 9, "diverged": 2 * 3}
    assert lost.loc[lost["outcome"] == "diverged", "failed_at_s"].notna().all()
    assert list(lost.loc[lost["outcome"] == "training_diverged", "seed"].unique()) == [1]
    assert set(frame[frame["probe_amplitude_m"].notna()]["outcome"]) == {"ok"}
    good = frame[frame["outcome"] == "ok"]
    assert np.allclose(good["tip_amplitude_m"], 2.7 * good["probe_amplitude_m"])


def test_beam_reads_the_scene_and_keeps_probe_and_tip_apart(frames, tree, collection):
    beam = row(frames["beam"], "small", "full_order")
    assert (beam["young_modulus_pa"], beam["density_kg_per_m3"]) == (104.0e9, 440.0)
    assert (beam["cells"], beam["omega_1_rad_per_s"]) == ("8 x 2", 400.0)
    assert (
        beam["thesis_test_probe_m"] == 0.0496 and beam["test_tip_m"] > 2 * beam["test_probe_m"] > 0
    )
    assert "omega_1_quadratic_rad_per_s" not in frames["beam"].columns
    structure = collection.find("small", "full_order", "structure")
    from vibrom.report.beam import frequencies

    with_quadratic = structure.assign(frequency_quadratic=structure["frequency"] * 0.75)
    assert frequencies(with_quadratic)["omega_1_quadratic_rad_per_s"] == 300.0


def test_the_beam_has_no_noise_in_its_last_digits():
    from vibrom.report.beam import ten_digits

    assert [
        ten_digits(value) for value in (0.010000000000000007, np.float64(398.0524086482218), "a", 7)
    ] == [0.01, 398.0524086, "a", 7]


def test_a_failure_and_leaving_the_training_range_are_two_things():
    from vibrom.artefacts.data import outcome_variables

    ends = [
        ("diverged", 0.15),
        ("left_range", 0.07),
        ("left_range", 0.09),
        ("step_underflow", 0.2),
        ("ok", np.nan),
    ]
    runs = [xr.Dataset(outcome_variables(*end)) for end in ends]
    assert tables.first_times([*runs, None]) == {"failed_at_s": 0.15, "left_range_at_s": 0.07}
    assert all(np.isnan(value) for value in tables.first_times(runs[-1:]).values())


def test_points_where_the_full_order_failed_do_not_count_against_a_model():
    omega, truth, ours = [1.0, 2.0, 3.0], [1.0, np.nan, 2.0], [1.1, 5.0, 2.6]
    frame = pd.concat(
        [
            pd.DataFrame(
                {
                    "case": "small",
                    "method": method,
                    "seed": seed,
                    "omega_rad_per_s": omega,
                    "probe_amplitude_m": values,
                    "outcome": "ok",
                }
            )
            for method, seed, values in (("full_order", -1, truth), ("split", 0, ours))
        ]
    )
    assert curves.summary(frame)["median_amplitude_error_percent"].iloc[1] == pytest.approx(
        20.0
    )  # of 10 and 30
    frame.loc[
        (frame["method"] == "split") & (frame["omega_rad_per_s"] != 2.0), "probe_amplitude_m"
    ] = np.nan
    assert np.isnan(curves.summary(frame)["median_amplitude_error_percent"].iloc[1])


def test_a_variant_is_called_after_its_method():
    said = {
        "ssmlearn": "SSMLearn",
        "ssmlearn_11": "SSMLearn 11",
        "split_plus": "SPLIT+",
        "split_wide": "SPLIT wide",
        "pysindy_modal": "pysindy modal",
    }
    assert {name: thesis.label(name) for name in said} == said
    assert np.isnan(
        thesis.percent("decay", "small", "ssmlearn_11")[0]
    )  # the thesis's number is that of order 3


def test_files_in_all_formats_and_the_same_bytes_twice(tree, tmp_path):
    written = []
    for folder in ("first", "second"):
        paths = [
            str(tmp_path / folder / f"{name}.{form}")
            for name in names.tables("models", "cost", "effects")
            for form in names.TABLE_FORMATS
        ]
        step.run(
            scores=tree.scores,
            artefacts=tree.artefacts,
            tables=paths,
            provenance={"source_digest": "feed"},
        )
        written.append({path.split("/")[-1]: open(path, "rb").read() for path in paths})
    assert written[0] == written[1] and len(written[0]) == 3 * len(
        names.tables("models", "cost", "effects")
    )
    assert b"\\toprule" in written[0]["forced.tex"] and b"diverged" in written[0]["forced.tex"]
    html = written[0]["forced.html"].decode()
    assert (
        "<table" in html
        and "ok 2, diverged 1" in html
        and 'class="failed"' in html
        and "http" not in html
    )
    again = pd.read_csv(tmp_path / "first" / "decay.csv")
    assert (
        again.loc[(again["case"] == "small") & (again["method"] == "split"), "nmte_percent"].item()
        == 3.0
    )


def test_numbers_are_printed_with_four_digits():
    printed = [
        presentation.number(value)
        for value in (0.0, 1.0, 0.074231, 398.0524, 13644.66, 2.5e-7, np.nan, 7)
    ]
    assert printed == ["0", "1.000", "0.07423", "398.1", "13645", "2.500e-07", "–", "7"]


def test_a_model_that_was_not_run_says_why(tree, collection, scores):
    from vibrom.report.collection import Collection
    from vibrom.report.scores import Scores

    fewer = Scores(
        scores.frame[
            ~((scores.frame["method"] == "split") & (scores.frame["experiment"] == "decay"))
        ]
    )
    assert row(tables.build("decay", collection, fewer), "small", "split")["outcome"] == "not run"
    loaders = dict(collection.loaders)
    said = ((), "skipped", {"units": "1", "long_name": "outcome"})
    skipped = collection.find("small", "split", "rom", "seed_0").assign(outcome=said)
    for seed in ("seed_0", "seed_1", "seed_2"):
        loaders["small", "split", seed, "rom"] = lambda: skipped
    assert (
        row(tables.build("decay", Collection(loaders), fewer), "small", "split")["outcome"]
        == "skipped"
    )


def test_what_an_effect_is_worth_stands_beside_the_whole_scene(frames):
    frame = frames["effects"][frames["effects"]["case"] == "small"].set_index("left_out")
    assert list(frame.index) == ["nothing", "elasticity", "rayleigh_damping", "stop"]
    less = frame.loc["rayleigh_damping"]
    assert (
        less["decay_nmte_percent"],
        less["omega_1_rad_per_s_change_percent"],
        less["seconds_ratio"],
    ) == (16.0, 0.0, 2.0)
    assert less["decay_amplitude_m_change_percent"] == pytest.approx(50.0) and less[
        "decay_amplitude_m"
    ] == pytest.approx(0.05 * 0.75)
    assert (
        less["microseconds_per_step_with"],
        less["microseconds_per_step_without"],
    ) == pytest.approx((20.0, 10.0))
    printed = presentation.readable("effects", frame.reset_index()).set_index("Left out")
    assert printed.loc["rayleigh_damping", "Decay amplitude [m]"] == "0.03750 (+50 %)"
    assert (
        printed.loc["rayleigh_damping", "ω1 [rad/s]"] == "400.0"
    )  # nothing changed, nothing beside it
    assert presentation.marks("effects", frame.reset_index()) == ["reference", "", "", "failed"]


def test_tables_of_a_family_need_no_scores_and_no_reduced_model(tree, tmp_path, frames):
    path = str(tmp_path / "effects.csv")
    step.run(
        artefacts=[name for name in tree.artefacts if name.endswith("/effects.nc")], tables=[path]
    )
    pd.testing.assert_frame_equal(pd.read_csv(path), frames["effects"], check_dtype=False)


def test_small_changes_are_printed_with_two_digits_and_none_not_at_all():
    said = [
        presentation.with_change("1", change)
        for change in (0.0, 0.004, -0.02, 1.27, -9.96, 62.4, -100.0, np.nan)
    ]
    assert said == [
        "1",
        "1",
        "1 (-0.02 %)",
        "1 (+1.3 %)",
        "1 (-10 %)",
        "1 (+62 %)",
        "1 (-100 %)",
        "1",
    ]
