"""Tables and figures of robustness tests: counts, intervals and medians by hand, gaps in words."""

import numpy as np
import pytest
import studies

from vibrom.report import figures, tables
from vibrom.report.collection import Collection, Key
from vibrom.report.scores import Scores

TRUTH = studies.TRUTH
NOBODY = Scores([])


def run(**seeds):
    """With these seeds of split; each is a function that makes its dataset."""
    scene = "folding"
    loaders = {
        Key(scene, "full_order", None, "frc"): studies.response_curve,
        Key(scene, "full_order", None, "robustness"): studies.coarse_steps,
    }
    for name, make in seeds.items():
        loaders[Key(scene, "split", int(name.removeprefix("seed_")), "robustness")] = make
    return Collection(loaders)


@pytest.fixture(scope="module")
def collection():
    return run(
        seed_0=lambda: studies.robustness(0, 3, TRUTH * [1.01, 1.02, np.nan, 0.97, 1.0], np.nan),
        seed_1=lambda: studies.robustness(1, 1, TRUTH * [1.01, 1.02, 1.1, 0.97, 1.0], 2.0),
        seed_2=lambda: studies.robustness(2, 0, np.roll(TRUTH, 1) * 0.9, 4.0),
    )


def only(name, collection, guard, integrator):
    """The one row of this guard and integrator."""
    rows = tables.make(name, collection, NOBODY).rows
    found = [row for row in rows if (row["guard"], row["integrator"]) == (guard, integrator)]
    assert len(found) == 1
    return found[0]


def test_outcomes_are_counted_with_wilson_intervals(collection):
    rows = tables.make("robustness", collection, NOBODY).rows
    pairs = [("none", "tight"), ("none", "loose"), ("bounded", "tight")]  # one was not evaluated
    assert [(row["guard"], row["integrator"]) for row in rows] == pairs
    plain = rows[0]
    names = ("runs", "diverged", "left_range", "ok", "not_asked")
    assert tuple(plain[name] for name in names) == (30, 4, 3, 23, 0)
    assert plain["median_failure_periods"] == pytest.approx(1.5)  # of 1, 2, 3 and 1
    # 26 of 30 by Wilson's formula, z = 1.959964: centre (p + z^2/2n)/(1 + z^2/n), half width z
    # sqrt(p(1-p)/n + z^2/4n^2)/(1 + z^2/n).
    p, n, z2 = 26 / 30, 30, 1.959964**2
    centre = (p + z2 / (2 * n)) / (1 + z2 / n)
    half = np.sqrt(z2 * (p * (1 - p) / n + z2 / (4 * n**2))) / (1 + z2 / n)
    assert plain["held_percent"] == pytest.approx(100 * p)
    ends = (plain["held_low_percent"], plain["held_high_percent"])
    assert ends == pytest.approx((100 * (centre - half), 100 * (centre + half)), rel=1e-6)
    assert rows[2]["held_percent"] == 100.0


def test_guards_are_compared_by_medians_over_seeds(collection):
    plain, bounded = (only("guards", collection, guard, "tight") for guard in ("none", "bounded"))
    assert (plain["points"], plain["points_with_value"]) == (15, 14)
    # Medians of the seeds: of 1, 2, failed, 3, 0: 2; of 1, 2, 10, 3, 0: 2; of the shifted curve 10,
    # 55, 55, 80, 80: 55.
    assert plain["median_amplitude_error_percent"] == pytest.approx(2.0)
    assert plain["median_amplitude_error_percent_max"] == pytest.approx(55.0)
    # The curve with a gap has no peak; the others are 10 % too high and 10 % too low, in place and
    # one frequency off.
    peaks = [plain[f"peak_error_percent{end}"] for end in ("", "_min", "_max")]
    assert peaks == pytest.approx([0.0, -10.0, 10.0]) and plain["peak_steps"] == pytest.approx(0.5)
    assert plain["decay_nmte_percent"] == pytest.approx(4.0)  # of failed, 2 and 4
    assert np.isnan(plain["decay_nmte_percent_max"])
    assert (plain["decays"], plain["energy_rises"], plain["envelope_rises"]) == (6, 3, 0)
    names = ("median_amplitude_error_percent", "peak_error_percent", "energy_rises")
    assert [bounded[name] for name in names] == [0.0, 0.0, 0]
    assert str(plain["outcome"]) == "ok"


def test_full_order_at_coarse_steps(collection):
    made = tables.make("full_order_steps", collection, NOBODY)
    rows = made.rows
    assert [row["points_with_value"] for row in rows] == [4, 4, 5, 5]
    assert [row["median_failure_periods"] for row in rows][:2] == [7.0, 7.0]
    whole = next(row for row in rows if (row["steps_per_period"], row["forcing"]) == (100, 1.0))
    assert whole["median_amplitude_error_percent"] == pytest.approx(10.0)
    assert whole["peak_error_percent"] == pytest.approx(-10.0) and whole["gamma"] == 0.55
    other = [row["median_amplitude_error_percent"] for row in rows if row["forcing"] == 2.0]
    assert np.isnan(other).all()  # nothing to compare with
    assert b"no_<wbr>convergence 1" in tables.render(made, "html", "")
    assert rb"$\gamma$" in tables.render(made, "tex", "")


def written(figure):
    """Titles and notes of its panels, each as on one line."""
    titles = [axes.get_title(loc="left") for axes in figure.axes]
    notes = [text.get_text() for axes in figure.axes for text in axes.texts]
    return {" ".join(words.split()) for words in titles + notes if words}


def test_figures_count_what_failed(collection):
    figure = figures.make("robustness_map_folding", collection, NOBODY)
    assert written(figure) == {"SPLIT", "none 4 of 18", "bounded 0 of 18"}


def test_a_guard_that_does_not_suit_a_model_is_no_failure_of_it():
    """Nothing was evaluated, so nothing held and nothing was lost."""
    alone = run(seed_2=lambda: studies.robustness(2, 0, TRUTH, 4.0, guarded="unsupported"))
    row = only("robustness", alone, "bounded", "tight")
    assert (row["runs"], row["not_asked"], str(row["outcome"])) == (0, 10, "unsupported")
    shares = [row[f"held{end}_percent"] for end in ("", "_low", "_high")]
    assert np.isnan(shares).all()
    row = only("guards", alone, "bounded", "tight")
    assert row["decays"] == 0 and row["energy_rises"] is None
    assert str(row["outcome"]) == "unsupported"
    figure = figures.make("robustness_map_folding", alone, NOBODY)
    assert written(figure) == {"SPLIT", "none 0 of 6", "bounded –"}


def test_a_map_without_a_model_says_why():
    alone = run(seed_2=lambda: studies.robustness(2, 0, TRUTH, 4.0, guarded="training_diverged"))
    figure = figures.make("robustness_map_folding", alone, NOBODY)
    assert "bounded training diverged" in written(figure)


def test_a_run_without_robustness_tests_is_no_error():
    empty = Collection({})
    for name in ("robustness", "guards", "full_order_steps"):
        assert not tables.make(name, empty, NOBODY).rows
