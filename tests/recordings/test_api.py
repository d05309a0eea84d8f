"""The few lines of Python that `vibrom.api` promises, on a motion that is known."""

import numpy as np
import pytest
from oscillator import Oscillator, noisy

import vibrom
from vibrom.artefacts.files import DataError
from vibrom.config.errors import SettingsError
from vibrom.models.training import Unsupported

IT, TIME = Oscillator(), np.arange(0.0, 10.0, 1 / 400)


@pytest.fixture(scope="module")
def recorded():
    both = (noisy(IT.motion(TIME, start), 0.01) for start in (1.0, 0.8))
    return vibrom.of_arrays(TIME, *([x] for x in both))


@pytest.fixture(scope="module")
def model(recorded):
    return vibrom.fit(recorded, "ssmlearn", order_dynamics=5)


def test_load_fit_and_predict_in_three_lines(tmp_path, recorded, model):
    for name, start in (("a", 1.0), ("b", 0.8)):
        rows = np.column_stack([1e3 * TIME, 1e3 * noisy(IT.motion(TIME, start), 0.01)])
        np.savetxt(tmp_path / f"{name}.csv", rows, delimiter=",")
    files = [tmp_path / "a.csv", tmp_path / "b.csv"]
    loaded = vibrom.load(files, time_unit="ms", length_unit="mm")
    np.testing.assert_allclose(
        loaded.train[0].displacement, recorded.train[0].displacement, atol=1e-9
    )
    found = vibrom.fit(loaded, "ssmlearn", order_dynamics=5)
    decay = found.predict(loaded.test[0])
    assert decay.shape == (len(loaded.test[0].time), 1)
    truth = IT.motion(loaded.test[0].time, 0.8)[:, None]
    assert np.abs(decay - truth).max() < 0.02
    assert found.error(loaded.test[0]) == pytest.approx(model.error(recorded.test[0]), rel=1e-3)


def test_small_motions_have_the_known_frequency_and_damping(model):
    pole = model.eigenvalues[model.eigenvalues.imag > 0][0]
    assert pole.imag == pytest.approx(IT.omega, rel=1e-3)
    assert pole.real == pytest.approx(-IT.damping, rel=0.03)


def test_a_saved_model_answers_as_before(tmp_path, recorded, model):
    model.save(tmp_path / "it.nc")
    again = vibrom.open_model(tmp_path / "it.nc")
    assert again.channels == ("channel_1",)
    test = recorded.test[0]
    np.testing.assert_array_equal(again.predict(test), model.predict(test))


def test_a_calibrated_model_swings_as_far_as_was_measured(tmp_path, model):
    """And twice the strength drives a small motion twice as far."""
    driven = model.calibrated(frequency=30.0, amplitude=0.02)
    assert driven.response([30.0], periods=100)[0, 0] == pytest.approx(0.02, rel=1e-3)
    assert driven.response([30.0], 2.0, 100)[0, 0] == pytest.approx(0.04, rel=5e-3)
    driven.save(tmp_path / "it.nc")
    again = vibrom.open_model(tmp_path / "it.nc")
    assert again.response([30.0], periods=100)[0, 0] == pytest.approx(0.02, rel=1e-3)


def test_wrong_settings_and_methods_are_one_line():
    with pytest.raises(SettingsError, match="filter = 'nun' is not known; choose from none"):
        vibrom.of_arrays(TIME, [IT.motion(TIME, 1.0)], [], filter="nun")
    with pytest.raises(SettingsError, match="time_unit = 'h' is not known"):
        vibrom.load(["a.csv"], time_unit="h")
    data = vibrom.of_arrays(TIME, [IT.motion(TIME, 1.0)], [])
    with pytest.raises(SettingsError, match="method = 'ssmlaern' is not known; did you mean"):
        vibrom.fit(data, "ssmlaern")
    with pytest.raises(SettingsError, match="order_dynamics = -1 must be at least 1; change it"):
        vibrom.fit(data, "ssmlearn", order_dynamics=-1)
    with pytest.raises(Unsupported, match="modal_projection needs mass"):
        vibrom.fit(data, "modal_projection")


def test_a_file_that_holds_no_model_is_not_said_to_be_deleted(tmp_path):
    """A measurement may have been given by mistake."""
    (tmp_path / "measured.csv").write_text("time,tip\n0,1\n")
    with pytest.raises(DataError, match="measured.csv: no model that FittedModel.save wrote; give"):
        vibrom.open_model(tmp_path / "measured.csv")


def test_what_is_public_is_listed_and_documented():
    for name in vibrom.PUBLIC:
        assert name in dir(vibrom) and getattr(vibrom, name).__doc__
    with pytest.raises(AttributeError):
        _ = vibrom.nothing
