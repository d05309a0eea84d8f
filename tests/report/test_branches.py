"""Response curves with all branches: landmarks, medians and the headline's cells by hand."""

import subprocess
import sys

import numpy as np
import pytest
import xarray as xr

from vibrom.artefacts.data import variable
from vibrom.artefacts.outcome import Tally
from vibrom.report import answer as answered
from vibrom.report import headline, sentences, tables
from vibrom.report.branches import landmark, scenes
from vibrom.report.collection import Collection, Key
from vibrom.report.scores import Score, Scores

OMEGA = 100.0
FOLDED = {  # up, back over the unstable part, and down: folds at 104 and 102 rad/s
    "angular_frequency": [90.0, 100.0, 104.0, 103.0, 102.0, 106.0, 110.0],
    "maximum": [0.1, 0.3, 0.5, 0.45, 0.4, 0.2, 0.1],
    "stable": [1, 1, 1, 0, 1, 1, 1],
    "kind": ["regular", "regular", "fold", "regular", "fold", "regular", "end"],
}
PLAIN = {
    "angular_frequency": [90.0, 100.0, 110.0],
    "maximum": [0.1, 0.6, 0.1],
    "stable": [1, 1, 1],
    "kind": ["regular", "regular", "end"],
}


def answer(curve, branch=0, along="angular_frequency"):
    """An artefact with this curve, along the frequency or along the forcing."""
    count = len(curve["kind"])
    columns = {
        name: variable("point", np.array(curve[name]), "1", name) for name in ("stable", "kind")
    }
    for name in ("angular_frequency", "forcing"):
        columns[name] = variable((), 1.0, "1", name)
    columns[along] = variable("point", np.array(curve["angular_frequency"]), "1", along)
    dims = ("probe", "point")
    return xr.Dataset(
        {
            **columns,
            "branch": variable("point", np.full(count, branch), "1", "branch"),
            "maximum": variable(dims, [curve["maximum"]], "m", "maximum"),
            "phase": variable(dims, np.zeros((1, count)), "rad", "phase"),
            "multiplier_largest": variable("point", np.full(count, 0.9), "1", "multiplier"),
            "outcome": variable("point", np.full(count, "ok", object), "1", "outcome"),
        },
        {"probe": ["probe"]},
    )


def structure():
    return xr.Dataset(
        {"frequency": ("mode", [OMEGA]), "damping_ratio": ("mode", [0.0])},
    )


@pytest.fixture(scope="module")
def collection():
    """Of `folding` a full order, a model with two seeds, of which one has its folds; of `small`
    nothing but a structure.
    """
    made = {
        Key("small", "full_order", None, "structure"): structure(),
        Key("folding", "full_order", None, "structure"): structure(),
        Key("folding", "full_order", None, "branches"): answer(FOLDED),
        Key("folding", "split", 0, "branches"): answer(FOLDED),
        Key("folding", "split", 1, "branches"): answer(PLAIN),
        Key("folding", "full_order", None, "s_curve"): answer(FOLDED, along="forcing"),
        Key("folding", "split", 0, "s_curve"): answer(FOLDED, along="forcing"),
        Key("folding", "split", 1, "s_curve"): answer(PLAIN, along="forcing"),
    }
    return Collection({key: (lambda data=data: data) for key, data in made.items()})


@pytest.fixture(scope="module")
def scores():
    """Of the two seeds."""
    found = {
        "folds": (2.0, 0.0),
        "fold_frequency_error_percent": (0.5, np.inf),
        "stable_amplitude_error_percent": (1.0, np.inf),
        "peak_frequency_error_percent": (0.25, np.nan),  # the other amplitude saturates
        "peak_error_percent": (0.0, 20.0),
        "wrong_stable_motions": (0.0, 4.0),
    }
    return Scores(
        Score("folding", "split", seed, "branches", name, values[seed], "1", 1.0, Tally(["ok"]))
        for name, values in found.items()
        for seed in (0, 1)
    )


def test_landmarks_of_the_full_order(collection):
    found = {
        name: landmark(collection, "folding", name)
        for name in ("main folds", "upper fold", "lower fold", "peak", "peak frequency", "motions")
    }
    assert list(found.values()) == pytest.approx([2.0, 1.04, 1.02, 0.5, 1.04, 7.0])
    assert landmark(collection, "small", "peak") is None
    assert scenes(collection) == ["folding"]


def test_every_motion_is_a_row_and_every_model_a_line(collection, scores):
    made = tables.make("branches", collection, scores)
    assert len(made.rows) == 7 + 7 + 3
    row = made.frame.iloc[3]
    assert (row["branch"], row["point"], row["stable"], row["kind"]) == (0, 3, 0, "regular")
    assert row["omega_rad_per_s"] == 103.0 and row["probe_amplitude_m"] == 0.45
    lines = made.printed.frame.set_index("Model")
    full, split = lines.iloc[0], lines.iloc[1]
    assert full["Points"] == "7" and full["Highest amplitude [m]"] == "0.5000"
    # Between 102 and 104 two motions are stable; the model's other seed has one everywhere.
    assert full["Two stable motions over [rad/s]"] == "2.000"
    assert split["Main folds [–]"] == "1.0 (0 to 2.0)" and split["Points"] == "10"


def test_folds_in_the_forcing_are_a_line_a_model(collection, scores):
    """Small motions end at the first fold, large ones at the second. Where half of the seeds have
    none, the median has none.
    """
    full, split = tables.make("s_curve", collection, scores).rows
    assert (full["folds"], full["upper_fold"], full["lower_fold"]) == (2.0, 104.0, 102.0)
    assert split["folds"] == 1.0 and split["folds_min"] == 0.0 and split["folds_max"] == 2.0
    assert np.isnan(split["upper_fold"]) and np.isnan(split["lower_fold"])


def test_seeds_with_the_folds_of_the_full_order_are_counted(collection, scores):
    made = tables.make("folds", collection, scores)
    full, split = made.rows
    assert full["folds"] == 2.0 and np.isnan(full["fold_frequency_error_percent"])
    assert split["alike"] == 1 and split["seeds"] == 2
    # A seed without folds is infinitely wrong, and so is the median of two.
    assert np.isnan(split["fold_frequency_error_percent"])
    assert split["fold_frequency_error_percent_min"] == 0.5
    assert split["peak_error_percent"] == 10.0 and split["wrong_stable_motions_max"] == 4.0
    # A flat top has no frequency, which is no failure.
    assert dict(zip(made.printed.head, made.printed.lines[1]))["Peak frequency [%]"] == "0.250"
    assert headline.folds(split) == "1 of 2, 10.0"
    (frame,) = headline.sections({"folds": made}).values()
    assert frame.to_numpy().tolist() == [["SPLIT", "1 of 2, 10.0"]]


def test_the_answer_says_who_knows_that_two_motions_are_possible(collection, scores):
    *_, said = sentences.remarks(answered.of(collection, scores), collection)
    assert said == (
        "In folding the full order has two motions between its folds; with folds: SPLIT in 1 of 2 "
        "seeds."
    )


def test_curves_are_read_without_solvers():
    """Every job of tables and figures reads some; numba alone takes half a second to import."""
    code = "import sys, vibrom.report.answer, vibrom.report.tables.folds; print(*sys.modules)"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert not {"numba", "scipy.interpolate", "skfem"} & set(run.stdout.split())
