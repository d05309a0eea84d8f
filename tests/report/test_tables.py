"""Tables: medians by hand, failures shown, the thesis's numbers in the right cells."""

import numpy as np
import pytest
import xarray as xr
from small_run import DIVERGES, FAILED_AT, altered

from vibrom.artefacts.data import outcome_variables
from vibrom.artefacts.outcome import Outcome, Tally
from vibrom.report import errors, tables
from vibrom.report.collection import Collection
from vibrom.report.columns import Column, number, with_change
from vibrom.report.scores import Scores
from vibrom.report.table import FAILED, REFERENCE, Printed, printed, table
from vibrom.report.tables.beam import ten_digits
from vibrom.thesis import published as thesis
from vibrom.thesis.labels import label


@pytest.fixture(scope="module")
def made(collection, scores):
    """Tables by name, each made once."""
    names = ("beam", "eigenvalues", "reconstruction", "decay", "forced", "run_times", "frc")
    names += ("break_even", "ablation", "backbone")
    return {name: tables.make(name, collection, scores) for name in names}


def row(table, case, method):
    """The one of this case and method."""
    found = [row for row in table.rows if (row["case"], row["method"]) == (case, method)]
    assert len(found) == 1, f"{len(found)} rows for {case}, {method}"
    return found[0]


def cells(table, case, method) -> dict:
    """As printed, by heading."""
    at = table.rows.index(row(table, case, method))
    return dict(zip(table.printed.head, table.printed.lines[at]))


def test_every_case_has_every_model_and_the_full_order_model_is_called_full_order(made):
    for name in ("eigenvalues", "reconstruction", "decay", "forced", "run_times"):
        models = ("full_order", "modal_projection", "split", "split_plus")
        expected = [(case, model) for case in ("small", "large") for model in models]
        assert [(row["case"], row["method"]) for row in made[name].rows] == expected, name
    assert [row["method"] for row in made["beam"].rows] == ["full_order"] * 2


@pytest.mark.parametrize("name", ["reconstruction", "decay", "forced"])
def test_error_tables_have_the_columns_of_the_contract(made, name):
    first = ["case", "method", "nmte_percent", "nmte_percent_min", "nmte_percent_max"]
    first += ["thesis_percent", "thesis_outcome"]
    assert list(made[name].frame.columns)[:7] == first


def test_medians_are_those_of_the_artefacts(made, collection):
    for name, score in (("decay", "nmte_percent"), ("eigenvalues", "real_per_s")):
        values = [
            float(answer["score_value"].sel(score=score))
            for answer in collection.every("small", "split", name)
        ]
        found = row(made[name], "small", "split")
        spread = [found[f"{score}{end}"] for end in ("", "_min", "_max")]
        assert spread == [np.median(values), min(values), max(values)] and found["seeds"] == 2
    full = row(made["decay"], "small", "full_order")
    assert full["nmte_percent"] == 0.0
    assert cells(made["decay"], "small", "full_order")["NMTE [%]"] == "reference"


def test_failures_are_shown_not_dropped(made):
    split = row(made["forced"], "large", "split")  # one of two seeds failed: so did the median
    assert np.isnan(split["nmte_percent"]) and np.isfinite(split["nmte_percent_min"])
    assert np.isnan(split["nmte_percent_max"])
    assert split["outcome"] == Tally(["ok", "diverged"])
    assert cells(made["forced"], "large", "split")["Outcome"] == "ok 1, diverged 1"
    modal = row(made["forced"], "large", "modal_projection")
    assert np.isnan(modal["nmte_percent"]) and str(modal["outcome"]) == "diverged"
    assert modal["failed_at_s"] == pytest.approx(FAILED_AT)
    assert str(row(made["forced"], "small", "modal_projection")["outcome"]) == "ok"
    marks = made["forced"].printed.marks
    assert marks[made["forced"].rows.index(modal)] == FAILED and marks[0] == REFERENCE


def test_a_model_that_could_not_be_fitted_has_an_outcome_in_every_table(made):
    scene, method, _ = DIVERGES
    for name in ("reconstruction", "decay", "forced", "eigenvalues", "run_times", "backbone"):
        unfit = row(made[name], scene, method)
        assert unfit["outcome"][Outcome.TRAINING_DIVERGED] == 1, name
        numbers = [column for column in made[name].columns if column.spread]
        # As many seeds failed as did not.
        assert numbers and all(np.isnan(unfit[column.name]) for column in numbers), name


def test_thesis_numbers_stand_in_their_cells(made):
    assert row(made["decay"], "small", "split")["thesis_percent"] == 0.37445
    assert row(made["reconstruction"], "large", "modal_projection")["thesis_percent"] == 2.7082
    assert cells(made["forced"], "large", "modal_projection")["Thesis NMTE [%]"] == "17.3383"
    pair = row(made["eigenvalues"], "large", "modal_projection")
    assert (pair["thesis_real_per_s"], pair["thesis_imaginary_rad_per_s"]) == (-4.1405, 397.53)
    times = row(made["run_times"], "small", "split")
    assert (times["thesis_obtain_mapping_s"], times["thesis_frc_s"]) == (5903.2, 48.0)
    assert cells(made["run_times"], "small", "split")["Mapping [s]"].endswith(" [5903.2]")
    assert row(made["run_times"], "small", "full_order")["thesis_forced_s"] == 8208.4


def test_where_the_thesis_prints_fails_the_table_says_so():
    assert thesis.percent("forced", "folding", "ssmlearn")[1] == "fails"
    for unknown in (("decay", "small", "pysindy_modal"), ("decay", "my_scene", "split")):
        assert np.isnan(thesis.percent(*unknown)[0])
    failing = {"thesis_percent": np.nan, "thesis_outcome": "fails"}
    assert errors.THESIS[0].cell(failing) == "fails"
    assert np.isnan(thesis.percent("decay", "method", "split")[0])  # a scene of this name


def test_response_curves_have_one_row_a_point_with_value_or_outcome(made):
    frame = made["frc"].frame
    contract = ["case", "method", "seed", "omega_rad_per_s", "probe_amplitude_m"]
    contract += ["tip_amplitude_m", "phase_rad", "outcome", "failed_at_s"]
    assert list(frame.columns) == [*contract, "probe_half_range_m"]
    assert len(frame) == 2 * 9 * (1 + 1 + 2 + 2)
    lost = frame[frame["probe_amplitude_m"].isna()]
    assert dict(lost["outcome"].value_counts()) == {"training_diverged": 9, "diverged": 2 * 3}
    assert lost.loc[lost["outcome"] == "diverged", "failed_at_s"].notna().all()
    assert list(lost.loc[lost["outcome"] == "training_diverged", "seed"].unique()) == [1]
    assert set(frame[frame["probe_amplitude_m"].notna()]["outcome"]) <= {
        "ok",
        "left_range",
        "not_steady",
    }


def test_half_the_range_is_shown_where_the_artefact_has_it(made, collection):
    curve = collection.find("small", "full_order", "frc")
    rows = [
        row for row in made["frc"].rows if (row["case"], row["method"]) == ("small", "full_order")
    ]
    half = curve["half_range"].sel(probe="probe").values
    assert [row["probe_half_range_m"] for row in rows] == pytest.approx(half)
    keys = [("small", model, None, "frc") for model in ("full_order", "modal_projection")]
    without = altered(
        collection, {key: lambda curve: curve.drop_vars("half_range") for key in keys}
    )
    only = Collection({key: made for key, made in without.loaders.items() if key in keys})
    assert "probe_half_range_m" not in tables.make("frc", only, Scores([])).frame.columns


def test_a_failed_point_of_a_curve_is_infinitely_wrong_everywhere(made, collection):
    """Three of nine points failed: the median is that of the rest with three infinite ones."""
    truth, curve = (
        collection.find("large", model, "frc")["amplitude"].sel(probe="probe").values
        for model in ("full_order", "modal_projection")
    )
    error = np.sort(np.nan_to_num(100 * np.abs(curve / truth - 1), nan=np.inf))
    rows = tables.frc.shown(made["frc"].rows, ()).frame.set_index(["Case", "Model"])
    found = rows.loc[("large", "Modal projection")]
    assert found["Median amplitude error [%]"] == number(error[4]) and found["With a value"] == "6"
    assert found["Peak of the probe [m]"] == "–"  # a curve with gaps has none
    # Break-even has a number wherever an error is printed.
    assert np.isfinite(row(made["break_even"], "large", "modal_projection")["sweeps"])
    assert np.isnan(row(made["break_even"], "large", "split_plus")["sweeps"])


def test_break_even_by_hand(made, scores):
    found = row(made["break_even"], "small", "split")

    def median(model, name):
        return scores.spread("small", model, "run_times", name, worst=False).median

    offline = sum(
        median("split", f"{name}_s")
        for name in ("generate_training_data", "obtain_mapping", "obtain_dynamics")
    )
    assert found["offline_s"] == pytest.approx(offline)
    saved = median("full_order", "decay_s") - median("split", "decay_s")
    count = np.ceil(offline / saved) if saved > 0 else np.inf
    assert found["decays"] == count
    # The thesis: 1228.3 + 5903.2 s, and 0.2 of 1228.3, 1.4 of 8208.4, 48.0 of 269235.5.
    assert [found[f"thesis_{name}"] for name in ("decays", "forced_runs", "sweeps")] == [6, 1, 1]
    assert np.isnan(row(made["break_even"], "large", "modal_projection")["forced_runs"])


def test_beam_reads_the_scene_and_keeps_probe_and_tip_apart(made, collection):
    beam = row(made["beam"], "small", "full_order")
    assert (beam["young_modulus_pa"], beam["density_kg_per_m3"]) == (104.0e9, 440.0)
    structure = collection.find("small", "full_order", "structure")
    assert beam["cells"] == "8 x 2" and beam["omega_1_rad_per_s"] == pytest.approx(
        float(structure["frequency"][0]), rel=1e-9
    )
    assert beam["thesis_test_probe_m"] == 0.0496
    assert abs(beam["test_tip_m"]) > 2 * abs(beam["test_probe_m"]) > 0
    assert beam["omega_1_quadratic_rad_per_s"] < beam["omega_1_rad_per_s"]  # bilinear ones lock
    assert made["beam"].printed.head == ["Property", "small", "large"]
    bare = altered(
        collection,
        {
            (scene, "full_order", None, "structure"): lambda old: old.drop_vars(
                "frequency_quadratic", errors="ignore"
            )
            for scene in ("small", "large")
        },
    )
    names = tables.make("beam", bare, Scores([])).frame.columns
    assert "omega_1_quadratic_rad_per_s" not in names


def test_the_beam_has_no_noise_in_its_last_digits():
    values = (0.010000000000000007, np.float64(398.0524086482218), "a", 7)
    assert [ten_digits(value) for value in values] == [0.01, 398.0524086, "a", 7]


def test_a_failure_and_leaving_the_training_range_are_two_things():
    ends = [("diverged", 0.15), ("left_range", 0.07), ("left_range", 0.09)]
    ends += [("step_underflow", 0.2), ("ok", np.nan)]
    runs = [xr.Dataset(outcome_variables(*end)) for end in ends]
    assert errors.first_times([*runs, None]) == {"failed_at_s": 0.15, "left_range_at_s": 0.07}
    assert all(np.isnan(value) for value in errors.first_times(runs[-1:]).values())


def test_an_experiment_without_a_table_has_one_of_its_scores(made, scores):
    found = made["backbone"]
    names = ["case", "method", "frequency_error_percent", "frequency_error_percent_min"]
    names += ["frequency_error_percent_max", "seeds", "outcome"]
    assert list(found.frame.columns) == names
    assert found.printed.head[2] == "Frequency error [%]"
    value = scores.spread("small", "modal_projection", "backbone", "frequency_error_percent")
    assert row(found, "small", "modal_projection")["frequency_error_percent"] == value.median


def test_a_variant_is_called_after_its_method():
    said = {"ssmlearn": "SSMLearn", "ssmlearn_11": "SSMLearn 11", "split_plus": "SPLIT+"}
    said |= {"split_wide": "SPLIT wide", "pysindy_modal": "pysindy modal"}
    assert {name: label(name) for name in said} == said
    # The thesis's number is that of order 3.
    assert np.isnan(thesis.percent("decay", "small", "ssmlearn_11")[0])


def test_numbers_are_printed_with_four_digits():
    values = (0.0, 1.0, 0.074231, 398.0524, 13644.66, 2.5e-7, np.nan, 7, None, Tally(["ok"]))
    printed = ["0", "1.000", "0.07423", "398.1", "13645", "2.500e-07", "–", "7", "–", "ok"]
    assert [number(value) for value in values] == printed


def test_small_changes_are_printed_with_two_digits_and_none_not_at_all():
    changes = (0.0, 0.004, -0.02, 1.27, -9.96, 62.4, -100.0, np.nan)
    words = ["1", "1", "1 (-0.02 %)", "1 (+1.3 %)", "1 (-10 %)", "1 (+62 %)", "1 (-100 %)", "1"]
    assert [with_change("1", change) for change in changes] == words


def test_a_row_with_a_value_that_has_no_column_is_refused_and_so_is_a_column_twice():
    case = Column("case", "Case")

    def shown(rows, columns):
        return Printed([], [], [])

    with pytest.raises(ValueError, match="table t: each of b"):
        table("t", [case], [{"case": "a", "b": 1.0}], shown)
    with pytest.raises(ValueError, match="table t: each of case"):
        table("t", [case, case], [{"case": "a"}], printed)


def test_a_table_needs_no_outcome_and_may_be_without_rows():
    columns = [Column("case", "Case"), Column("method", "Model"), Column("error", "Error [%]")]
    rows = [{"case": "a", "method": "full_order", "error": 1.0}, {"case": "a", "method": "split"}]
    made = table("t", columns, rows, printed).printed
    assert made.marks == [REFERENCE, ""] and made.lines[1] == ["a", "split", "–"]
    assert table("t", columns, [], printed).frame.to_csv(index=False) == "case,method,error\n"


def test_a_model_that_was_not_run_says_why(collection, scores):
    fewer = Scores(row for row in scores.rows if (row.method, row.experiment) != ("split", "decay"))
    found = row(tables.make("decay", collection, fewer), "small", "split")
    assert str(found["outcome"]) == "not_run"
    key = ("small", "split", 0, "rom")
    skipped = altered(
        collection, {key: lambda rom: rom.assign(outcome=rom["outcome"].copy(data="skipped"))}
    )
    assert str(row(tables.make("decay", skipped, fewer), "small", "split")["outcome"]) == "skipped"


def test_a_scene_called_na_is_a_scene(collection, scores):
    renamed = Collection(
        {
            key._replace(scene="NA"): made
            for key, made in collection.loaders.items()
            if key.scene == "small"
        }
    )
    own = Scores(row._replace(scene="NA") for row in scores.rows if row.scene == "small")
    found = tables.make("decay", renamed, own)
    assert np.isfinite(row(found, "NA", "split")["nmte_percent"])
    assert found.frame.to_csv(index=False).splitlines()[1].startswith("NA,full_order")


def test_the_ablation_stands_beside_the_whole_scene(made):
    rows = {row["left_out"]: row for row in made["ablation"].rows}
    assert list(rows) == ["nothing", "elasticity", "damping", "stop"]
    less = rows["damping"]
    assert less["decay_nmte_percent"] == 16.0 and less["seconds_ratio"] == 2.0
    assert less["omega_1_rad_per_s_change_percent"] == 0.0
    assert less["decay_amplitude_m_change_percent"] == pytest.approx(50.0)
    assert less["decay_amplitude_m"] == pytest.approx(0.05 * 0.75)
    steps = [less[f"microseconds_per_step_{which}"] for which in ("with", "without")]
    assert steps == pytest.approx([20.0, 10.0])
    printed = made["ablation"].printed.frame.set_index("Left out")
    assert printed.loc["damping", "Decay amplitude [m]"] == "0.03750 (+50 %)"
    assert printed.loc["damping", "ω1 [rad/s]"] == "400.0"  # nothing changed, nothing beside it
    assert made["ablation"].printed.marks == [REFERENCE, "", "", FAILED]
    assert rows["elasticity"]["outcome"] is Outcome.NEEDED
    assert rows["elasticity"]["needed_by"] == "modal_load inertia"
