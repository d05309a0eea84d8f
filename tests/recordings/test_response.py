"""Measured response curves and known operators, as files have them."""

import numpy as np
import pytest

from vibrom.artefacts.files import DataError
from vibrom.config.recorded import Operators, Response
from vibrom.recordings.operators import known
from vibrom.recordings.response import point, response

FREQUENCY, AMPLITUDE = np.array([3.0, 5.0, np.nan, 4.0]), np.array([1.0, 4.0, 2.0, 3.0])


def curve(path, frequency=FREQUENCY, amplitude=AMPLITUDE, **entries):
    np.savez(path / "sweep.npz", f=frequency, a=amplitude)
    given = {"file": str(path / "sweep.npz"), "frequency": "f", "amplitude": "a"} | entries
    return response(Response(**given), ("left", "right"), 1e-3)


def test_a_curve_is_in_si_units_in_the_order_of_the_sweep(tmp_path):
    frequency, amplitude, channel, numbers = curve(tmp_path, unit="Hz", channel="right")
    np.testing.assert_allclose(frequency, 2 * np.pi * np.array([3.0, 5.0, 4.0]))
    np.testing.assert_allclose(amplitude, [1e-3, 4e-3, 3e-3])
    assert channel == 1
    np.testing.assert_array_equal(numbers, [1, 2, 4])


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"frequency": FREQUENCY[:3]}, "3 frequencies and 4 amplitudes"),
        ({"amplitude": -AMPLITUDE}, "frequencies and amplitudes are positive"),
        ({"channel": "wright"}, "did you mean 'right'"),
    ],
)
def test_a_wrong_curve_is_one_line(tmp_path, changes, says):
    with pytest.raises(DataError, match=says):
        curve(tmp_path, **changes)


def test_points_are_counted_as_the_file_has_them_and_zero_is_the_largest(tmp_path):
    """The third one has no frequency: it is left out, and the fourth keeps its number."""
    _, amplitude, _, numbers = curve(tmp_path)
    found = [point(number, amplitude, numbers, "it") for number in (0, 1, 4)]
    assert found == [1, 0, 2]
    for number in (3, 5):
        with pytest.raises(DataError, match=f"it: calibrate = {number} is no point with"):
            point(number, amplitude, numbers, "it")


@pytest.mark.parametrize(
    ("mass", "stiffness", "says"),
    [(-1.0, 1.0, "the mass is not positive"), (1.0, -1.0, "the stiffness is not positive")],
)
def test_operators_of_no_body_are_refused(tmp_path, mass, stiffness, says):
    np.savez(tmp_path / "it.npz", M=np.diag([1.0, mass]), K=np.diag([9.0, stiffness]))
    with pytest.raises(DataError, match=says):
        known(Operators(file=str(tmp_path / "it.npz")), 2, 0.5)
