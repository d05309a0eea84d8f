"""Signals against their definitions."""

import numpy as np
import pytest
from scipy.integrate import quad

from vibrom import signals
from vibrom.config import plugs
from vibrom.signals import SignalError, load, total

TIME = np.linspace(0.0, 5.0, 2001)
ANY = {  # of each file, its shortest settings
    "sine": {"frequency": 3.0},
    "step": {},
    "pulse": {"duration": 0.5},
    "chirp": {"first": 2.0, "last": 30.0, "duration": 4.0},
    "noise": {"highest": 20.0},
}


def test_every_signal_is_a_number_at_every_instant(tmp_path):
    path = tmp_path / "shake.csv"
    path.write_text("t,a\n0,0\n1,2\n3,-1\n")
    every = {**ANY, "file": {"path": str(path)}}
    assert sorted(every) == list(plugs.names("signals"))
    for name, settings in every.items():
        values = load(name, settings).at(TIME)
        assert values.shape == TIME.shape and np.isfinite(values).all() and values.any()


def test_signals_of_one_load_add_up():
    both = total({"sine": {"frequency": 3.0}, "step": {"size": 2.0}})(TIME)
    np.testing.assert_array_equal(both, np.sin(3.0 * TIME) + 2.0)


@pytest.mark.parametrize(("shape", "area"), [("half_sine", 2 / np.pi), ("triangle", 0.5)])
def test_the_momentum_of_a_blow_is_the_area_of_its_shape(shape, area):
    blow = load("pulse", {"duration": 0.4, "size": 3.0, "begin": 1.0, "shape": shape})
    found = quad(lambda t: float(blow.at(np.array([t]))[0]), 0.9, 1.5, points=[1.0, 1.2, 1.4])[0]
    assert found == pytest.approx(3.0 * 0.4 * area, rel=1e-9)


def test_a_step_rises_on_a_straight_line():
    at = np.array([0.0, 1.0, 1.1, 1.2, 4.0])
    rising = load("step", {"begin": 1.0, "rise": 0.2, "size": 5.0}).at(at)
    np.testing.assert_allclose(rising, [0.0, 0.0, 2.5, 5.0, 5.0], atol=1e-12)
    np.testing.assert_array_equal(load("step", {"begin": 1.1}).at(at), [0, 0, 1, 1, 1])


@pytest.mark.parametrize("law", ["linear", "exponential"])
def test_the_frequency_of_a_chirp_is_the_rate_of_its_phase(law):
    """sin(phase) of the integral of the frequency, by quadrature."""
    wave = load("chirp", {"first": 2.0, "last": 30.0, "duration": 4.0, "law": law})
    linear = law == "linear"

    def frequency(t):
        return 2.0 + 7.0 * t if linear else 2.0 * 15.0 ** (t / 4.0)

    for end in (0.3, 1.7, 3.9):
        phase = quad(frequency, 0.0, end, epsabs=1e-12)[0]
        assert wave.at(np.array([end]))[0] == pytest.approx(np.sin(phase), abs=1e-9)
    assert not wave.at(np.array([4.1, 7.0])).any()


def test_noise_has_its_deviation_in_its_band_and_the_same_bytes_for_the_same_seed():
    """Over 2000 correlation times the variance is known to 3 sqrt(2/2000) = 10 %; outside the band
    only what the window of the spectrum leaks is left.
    """
    time = np.arange(60_000) * 0.01
    settings = {"lowest": 10.0, "highest": 30.0, "deviation": 2.0, "lines": 200}
    first, again, other = (load("noise", settings | {"seed": seed}).at(time) for seed in (4, 4, 5))
    assert first.tobytes() == again.tobytes()
    assert abs(np.corrcoef(first, other)[0, 1]) < 0.1
    assert first.var() == pytest.approx(4.0, rel=0.1)
    power = np.abs(np.fft.rfft(first * np.hanning(len(time)))) ** 2
    frequency = 2 * np.pi * np.fft.rfftfreq(len(time), 0.01)
    outside = (frequency < 9.5) | (frequency > 30.5)
    assert power[outside].sum() < 1e-6 * power.sum()


def test_noise_in_equal_steps_is_that_at_any_instants():
    """But for rounding of phases of some thousand radians."""
    noise, even = load("noise", {"highest": 20.0, "lines": 30}), np.arange(2000) * 0.05 + 0.3
    np.testing.assert_allclose(noise.at(even), noise.at(np.append(even, 1e3))[:-1], atol=1e-9)


def test_a_recording_is_linear_between_its_samples_and_zero_beyond(tmp_path):
    path = tmp_path / "hammer.csv"
    path.write_text("time;force\n0,0;0,0\n0,5;4,0\n2,0;-2,0\n")
    at = np.array([0.0, 0.25, 1.25, 2.0, 2.1])
    recorded = load("file", {"path": str(path), "scale": 10.0}).at(at)
    np.testing.assert_allclose(recorded, [0.0, 20.0, 10.0, -20.0, 0.0])
    late = load("file", {"path": str(path), "begin": 0.5}).at(at)
    np.testing.assert_allclose(late[:3], [4.0, 3.0, -1.0])
    np.save(tmp_path / "one.npy", np.array([0.0, 1.0, 0.0]))
    even = load("file", {"path": str(tmp_path / "one.npy"), "step": 0.5}).at(at)
    np.testing.assert_allclose(even, [0.0, 0.5, 0.0, 0.0, 0.0])


@pytest.mark.parametrize(
    ("text", "settings", "words"),
    [
        ("t,a\n0,1\n0,2\n", {}, "do not rise"),
        ("t,a\n0,1\n1,\n2,3\n", {}, "no number in sample 2"),
        ("a\n1\n2\n", {}, "give step"),
        ("t,a\n0,1\n1,2\n", {"value": "b"}, "'b'"),
        ("t,a\n0,1\n1,2\n", {"digest": "0"}, "has changed"),
    ],
)
def test_a_recording_that_cannot_be_meant_is_one_line(tmp_path, text, settings, words):
    path = tmp_path / "shake.csv"
    path.write_text(text)
    with pytest.raises(SignalError, match=words) as raised:
        load("file", {"path": str(path)} | settings).at(TIME)
    assert "\n" not in str(raised.value) and "signal.file.path" in str(raised.value)


def test_an_unknown_setting_of_a_signal_is_one_line():
    with pytest.raises(SignalError, match=r"signal.sine.frequncy is no setting; did you mean"):
        signals.load("sine", {"frequncy": 1.0})
