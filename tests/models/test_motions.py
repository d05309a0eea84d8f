"""Scores of a curve of motions that is off by another amount in each of its numbers."""

import numpy as np
import pytest
import xarray as xr

from vibrom.models.motions import errors
from vibrom.solvers.periodic.stability import Kind


def curve(frequency, amplitude, counts):
    """A branch that folds twice, unstable between the folds."""
    kind = np.full(len(frequency), Kind.REGULAR.value, object)
    kind[[0, -1]], kind[[4, 8]] = Kind.END.value, Kind.FOLD.value
    stable = np.ones(len(frequency), np.int8)
    stable[5:8] = 0
    return xr.Dataset(
        {
            "branch": ("point", np.zeros(len(frequency), int)),
            "angular_frequency": ("point", frequency),
            "forcing": 1.0,
            "stable": ("point", stable),
            "kind": ("point", kind),
            "maximum": (("probe", "point"), [amplitude]),
            "stable_motions": ("grid", counts),
        }
    )


def test_every_score_is_the_number_of_its_name():
    frequency = np.array([1.0, 2.0, 3.0, 4.0, 5.0, 4.5, 4.0, 3.5, 3.0, 4.0, 5.0, 6.0, 7.0])
    amplitude = np.array([1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0, 11.0])
    truth = curve(frequency, amplitude, [1, 2, 2, 1])
    off, higher = frequency.copy(), amplitude.copy()
    off[4], off[11] = 5.05, 6.12  # a fold and the peak
    higher[4], higher[6], higher[11] = 5.2, 9.1, 12.6
    found = errors(curve(off, higher, [1, 2, 1, 1]), truth, "frequency")
    along = [found.pop(f"{part}stable_amplitude_error_percent") for part in ("", "un")]
    assert found == pytest.approx(
        {
            "folds": 2.0,
            "fold_frequency_error_percent": 1.0,
            "fold_amplitude_error_percent": 4.0,
            "peak_frequency_error_percent": 2.0,
            "peak_error_percent": 5.0,
            "bistable_width_error_percent": 2.5,  # from 3 to 5.05 in place of 3 to 5
            "wrong_stable_motions": 1.0,
        }
    )
    # The unstable part is up to 30 % off, the stable ones 5 %, compared at equal arclength.
    assert along[0] < 10.0 < along[1] < 35.0
    exact = errors(truth, truth, "forcing")
    assert exact.pop("folds") == 2.0 and not any(exact.values())
    assert "fold_forcing_error_percent" in exact
