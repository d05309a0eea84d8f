"""A recorded scene: its artefacts, and what methods and experiments make of them."""

import numpy as np
import pytest
from oscillator import Oscillator

from vibrom.artefacts.data import open_dataset
from vibrom.artefacts.files import DataError
from vibrom.config.recorded import RecordedScene
from vibrom.models.recorded import structure, trajectories
from vibrom.steps import ask, fit, recorded

IT, TIME = Oscillator(), np.arange(0.0, 8.0, 1 / 400)
STARTS = {"train_1": 1.0, "train_2": 0.6, "test": 0.8}
SHAPE = np.array([1.0, 0.5])  # of two channels
# With unit masses the second mode, of 9 Hz, is at rest.
MODES = np.array([[1.0, 0.5], [-0.5, 1.0]]) / np.sqrt(1.25)
STIFFNESS = MODES.T @ np.diag([IT.omega**2, (2 * np.pi * 9) ** 2]) @ MODES
DAMPING = MODES.T @ np.diag([2 * IT.damping, 1.0]) @ MODES


def scene(folder, **changes):
    """The blocks of a scene as the workflow hands them on."""
    entries = [
        {"file": str(folder / f"{name}.npz"), "role": name.partition("_")[0]} for name in STARTS
    ]
    given = {"kind": "recorded", "name": "it", "description": "", "recordings": entries} | changes
    return RecordedScene.from_builtins(given).to_builtins()


def made(folder, blocks):
    """Paths of structure, train and test."""
    for name, start in STARTS.items():
        x = IT.motion(TIME, start)
        np.savez(folder / f"{name}.npz", t=TIME, a=SHAPE[0] * x, b=SHAPE[1] * x)
    np.savez(folder / "matrices.npz", M=np.eye(2), K=STIFFNESS, C=DAMPING)
    paths = {name: str(folder / f"{name}.nc") for name in ("structure", "train", "test")}
    recorded.run(**paths, scene=blocks, provenance={}, files=[])
    return paths


@pytest.fixture(scope="module", params=["motion alone", "operators"])
def paths(request, tmp_path_factory):
    folder = tmp_path_factory.mktemp("it")
    operators = {"file": str(folder / "matrices.npz"), "damping": "C"}
    extra = {"operators": operators} if request.param == "operators" else {}
    return made(folder, scene(folder, **extra)) | {"folder": folder, "known": bool(extra)}


def fitted(paths, method, seed=None, **settings):
    """The path of a fitted model, and its dataset."""
    name = str(paths["folder"] / f"{method}.nc")
    recipe = {"scene": "it", "method": method, "kind": method, "settings": settings}
    fit.run(
        structure=paths["structure"],
        train=None if method == "equations" else paths["train"],
        rom=name,
        losses=name.replace(".nc", "_losses.nc"),
        recipe=recipe | {"seed": seed, "device": "cpu"},
        provenance={},
    )
    return name, open_dataset(name, "rom")


def answer(paths, experiment, rom=None, settings=None, **reads):
    output = str(paths["folder"] / f"{experiment}.nc")
    ask.run(
        questions={experiment: settings or {}},
        names={"scene": "it", "method": "full_order" if rom is None else "it", "seed": None},
        samples=80,
        structure=paths["structure"],
        provenance={},
        rom=rom,
        integrator={},
        **{experiment: output},
        **reads,
    )
    return open_dataset(output, experiment)


def score(dataset, name):
    return float(dataset["score_value"].sel(score=name))


def test_the_artefacts_hold_the_motion_the_linear_part_and_every_recording(paths):
    known, train = (
        open_dataset(paths["structure"], "structure"),
        open_dataset(paths["train"], "trajectory"),
    )
    parts = trajectories(train)
    copies = 1 if paths["known"] else 2  # two channels are delayed on each side
    assert len(parts) == 2 and all(len(part.time) > 2500 for part in parts)
    assert train.sizes["dof"] == 2 * copies and list(train["probe"].values) == ["a", "b"]
    assert list(known["probe_dof"].values) == [0, copies]
    assert (structure(known) is not None) == paths["known"]
    assert float(known["frequency"][0]) == pytest.approx(IT.omega, rel=1e-3)
    ratio = IT.damping / IT.omega
    assert float(known["damping_ratio"][0]) == pytest.approx(ratio, rel=0.02)
    assert np.isnan(known["load"].values).all()
    assert known["load"].units == ("N" if paths["known"] else "m s-2")
    assert "slow motion from" in train.attrs["notes"]


@pytest.mark.parametrize(
    ("method", "settings", "error"),
    [
        ("ssmlearn", {}, 0.5),
        ("ssmlearn", {"tangent": "data", "order_dynamics": 5}, 0.5),
        ("decoupled_autoencoder", {"epochs": 30, "every": 5}, 5.0),
    ],
)
def test_methods_that_need_no_operators_predict_the_decay(paths, method, settings, error):
    rom, model = fitted(paths, method, 0 if "epochs" in settings else None, **settings)
    assert model["outcome"] == "ok"
    decay = answer(paths, "decay", rom, test=paths["test"], truth_decay=paths["test"])
    assert score(decay, "nmte_percent") < error
    poles = answer(paths, "eigenvalues", rom)
    assert score(poles, "imaginary_rad_per_s") == pytest.approx(IT.omega, rel=5e-3)


@pytest.mark.parametrize("method", ["modal_projection", "equations"])
def test_methods_that_need_more_are_skipped_and_say_why(paths, method):
    rom, model = fitted(paths, method)
    runs = paths["known"] and method == "modal_projection"
    assert model["outcome"] == ("ok" if runs else "skipped")
    decay = answer(paths, "decay", rom, test=paths["test"], truth_decay=paths["test"])
    if runs:
        assert score(decay, "nmte_percent") < 1.0
    else:
        reason = "equations of motion" if method == "equations" else "needs mass"
        assert decay["outcome"] == "skipped" and reason in decay.attrs["reason"]


def test_what_was_measured_stands_for_the_full_order(paths):
    poles = answer(paths, "eigenvalues")
    assert score(poles, "real_per_s") == pytest.approx(-IT.damping, rel=0.02)
    assert score(poles, "imaginary_rad_per_s") == pytest.approx(IT.omega, rel=1e-3)
    curve = answer(paths, "backbone", decay=paths["test"])
    omega, amplitude = (curve[name].values[0][5:-2] for name in ("angular_frequency", "amplitude"))
    np.testing.assert_allclose(omega, IT.frequency_at(amplitude), rtol=1e-3)


def test_an_unknown_load_drives_nothing(paths):
    rom, _ = fitted(paths, "ssmlearn")
    for model in (rom, None):
        forced = answer(paths, "forced", model, settings={"forcing": 1.0, "periods": 2})
        assert forced["outcome"] == "skipped"
        assert ("load" if model else "recording") in forced.attrs["reason"]


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"operators": {"file": "matrices.npz", "mass": "t"}}, "no 't'; did you mean|holds no 't'"),
        ({"operators": {"file": "train_1.npz", "mass": "a"}}, "is 1 x 3200, but there are 2"),
        ({"operators": {"file": "matrices.npz"}, "time_unit": "ms"}, "the first mode has 5 Hz"),
        ({"channels": ["a"]}, "channels names 1, but"),
        ({"forcing": {"load": [1.0]}}, "forcing.load has 1 entries for 2 channels"),
        ({"preparation": {"start": 7.9}}, "less than two periods after start"),
        ({"preparation": {"delays": 2}}, "delays = 2 is even"),
    ],
)
def test_what_contradicts_itself_is_one_line(tmp_path, changes, says):
    for block in changes.values():
        if isinstance(block, dict) and "file" in block:
            block["file"] = str(tmp_path / block["file"])
    with pytest.raises(DataError, match=says) as caught:
        made(tmp_path, scene(tmp_path, **changes))
    assert "\n" not in str(caught.value)


def linear(time, start, omega=30.0, damping=0.5):
    """A decay of x'' + 2 a x' + (omega^2 + a^2) x = 0 [m], from `start` at rest."""
    turned = omega * time
    wave = np.cos(turned) + damping / omega * np.sin(turned)
    return start * np.exp(-damping * time) * wave


def test_a_measured_response_tells_the_strength_of_the_load(tmp_path):
    """A linear oscillator driven by an unknown acceleration of 7 m/s2: its response is known in
    closed form, and a model that was trained on decays and calibrated at one point has all others.
    """
    omega = 30.0 + np.arange(-4.0, 5.0)
    amplitude = 7.0 / np.abs(30.0**2 + 0.5**2 - omega**2 + 1j * omega)
    np.savez(tmp_path / "sweep.npz", f=omega / (2 * np.pi), a=1e3 * amplitude)
    for name, start in STARTS.items():
        values = 1e3 * linear(TIME, start)
        np.savez(tmp_path / f"{name}.npz", t=TIME, x=values)
    curve = {"file": str(tmp_path / "sweep.npz"), "frequency": "f", "amplitude": "a", "unit": "Hz"}
    blocks = scene(tmp_path, length_unit="mm", forcing={"response": curve, "calibrate": 2})
    paths = {name: str(tmp_path / f"{name}.nc") for name in ("structure", "train", "test")}
    recorded.run(**paths, scene=blocks, provenance={}, files=[])
    known = open_dataset(paths["structure"], "structure")
    np.testing.assert_allclose(known["response_frequency"], omega)
    np.testing.assert_allclose(known["response_amplitude"], amplitude)
    paths["folder"] = tmp_path
    rom, _ = fitted(paths, "ssmlearn")
    found = answer(paths, "measured_response", rom, settings={"periods": 60})
    assert found["half_range"][1] == pytest.approx(amplitude[1], rel=2e-3)
    assert score(found, "amplitude_error_largest_percent") < 1.0
    forced = answer(paths, "frc", rom, settings={"forcing": 1.0, "frequencies": 3, "periods": 30})
    assert set(forced["outcome"].values) <= {"ok", "not_steady"}


def test_decays_for_tests_are_predicted_one_by_one(tmp_path):
    """Two with different lengths: the error of both is that of each."""
    blocks = scene(tmp_path)
    blocks["recordings"] = [
        item | {"role": role} for item, role in zip(blocks["recordings"], ("train", "test", "test"))
    ]
    blocks["recordings"][1]["end"] = 6.0
    paths = made(tmp_path, blocks) | {"folder": tmp_path}
    rom, _ = fitted(paths, "ssmlearn")
    decay = answer(paths, "decay", rom, test=paths["test"], truth_decay=paths["test"])
    assert score(decay, "nmte_percent") < 0.5
    parts = decay["part"].values
    assert (parts == 1).sum() - (parts == 0).sum() == pytest.approx(2.0 * 400, abs=100)
    curve = answer(paths, "backbone", rom, decay=str(tmp_path / "decay.nc"))
    omega, amplitude = (curve[name].values[0] for name in ("angular_frequency", "amplitude"))
    np.testing.assert_allclose(omega, IT.frequency_at(amplitude), rtol=3e-3)
