"""Motions under a recorded signal: a hardening oscillator, integrated by SciPy, whose load is known
to these tests alone.

    x'' + 2 a x' + omega^2 x + c x^3 = p u(t)
"""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.signal import chirp

from vibrom.artefacts.data import open_dataset
from vibrom.artefacts.files import DataError
from vibrom.config.recorded import RecordedScene
from vibrom.experiments import Given, experiment
from vibrom.methods.ssmlearn import SsmLearn
from vibrom.models.recorded import trajectories
from vibrom.models.reduced import Integrator, Reduced
from vibrom.models.training import Training, Unsupported
from vibrom.solvers.periodic.carried import swept, swings
from vibrom.steps import recorded

OMEGA, DAMPING, CUBIC, STRENGTH = 30.0, 0.6, 150.0, 40.0  # rad/s, 1/s, 1/(m s)^2, m/s2
TIME = np.arange(0.0, 8.0, 1 / 250)


def up(t):
    """Through the resonance."""
    return chirp(t, 3.5, TIME[-1], 6.5)


def beats(t):
    """Two lines beside one another: neither of one frequency nor of one amplitude."""
    return 1.5 * np.sin(27.0 * t) + np.cos(34.5 * t)


def motion(start, push=lambda t: 0.0 * t):
    def rate(t, y):
        return [y[1], STRENGTH * push(t) - 2 * DAMPING * y[1] - OMEGA**2 * y[0] - CUBIC * y[0] ** 3]

    ends = TIME[[0, -1]]
    return solve_ivp(rate, ends, [start, 0.0], t_eval=TIME, rtol=1e-9, atol=1e-12).y[0]


MOTIONS = {
    "train": (motion(1.2), 0 * TIME),
    "test": (motion(1.0), 0 * TIME),
    "calibration": (motion(0.0, up), up(TIME)),
    "forced": (motion(0.1, beats), beats(TIME)),
}


def scene(folder, roles, noise=0.0, channels=1, **changes):
    random, entries = np.random.default_rng(0), []
    for role in roles:
        x, u = MOTIONS[role]
        seen = np.outer(x, [1.0, -0.5][:channels])
        seen += noise * np.abs(seen).max(axis=0) * random.standard_normal(seen.shape)
        np.savez(folder / f"{role}.npz", t=1e3 * TIME, x=1e3 * seen, u=u)
        entry = {"file": str(folder / f"{role}.npz"), "role": role, "channels": ["x"]}
        entries.append(entry | ({"signal": "u"} if u.any() else {}))
    given = {"kind": "recorded", "name": "it", "description": "", "recordings": entries}
    return given | {"time_unit": "ms", "length_unit": "mm"} | changes


def asked(folder, blocks):
    """The fitted model, what is known of the scene, and the answer."""
    paths = {name: str(folder / f"{name}.nc") for name in ("structure", "train", "test")}
    plain = RecordedScene.from_builtins(blocks).to_builtins()
    recorded.run(**paths, scene=plain, provenance={}, files=[])
    known = open_dataset(paths["structure"], "structure")
    motions = trajectories(open_dataset(paths["train"], "trajectory"))
    rom = SsmLearn(order_decoder=3, order_dynamics=3).learn(Training(motions))
    model = Reduced.of_scene(rom, known, Integrator())
    question = experiment("measured_forcing")
    return model, known, lambda: question.ask(model, Given(known, 200, {})), question


ALL = ("train", "test", "calibration", "forced")


@pytest.mark.parametrize(
    ("noise", "delays", "strength", "error"),
    [(0.0, 1, 0.002, 0.2), (0.0, 5, 0.002, 1.0), (0.01, 5, 0.01, 1.2), (0.05, 5, 0.05, 4.0)],
)
def test_one_recording_tells_the_strength_and_another_is_predicted(
    tmp_path, noise, delays, strength, error
):
    """The filter takes some 1e-4 of the motion, and white noise leaves a third of its deviation in
    the state from which a prediction starts. Delayed copies of a driven motion differ from those of
    a decay by up to p u (k l)^2 / 2, with which goes most of the error without noise.
    """
    blocks = scene(tmp_path, ALL, noise, preparation={"delays": delays})
    model, _, answer, question = asked(tmp_path, blocks)
    assert model.strength == pytest.approx(STRENGTH, rel=strength)
    found = answer()
    assert found["outcome"] == "ok" and 0.4 < found["range_ratio"] < 1.0
    assert question.score(found, None)["nmte_percent"] < error
    assert found.sizes["time"] > 0.9 * len(TIME)


def test_a_known_load_needs_no_calibration(tmp_path):
    blocks = scene(tmp_path, ("train", "test", "forced"), channels=2)
    model, known, answer, question = asked(
        tmp_path, blocks | {"forcing": {"load": [STRENGTH, -0.5 * STRENGTH]}}
    )
    assert model.strength == 1.0
    assert question.score(answer(), None)["nmte_percent"] < 1.5


def test_a_harmonic_load_is_as_strong_as_the_recorded_one(tmp_path):
    """Small: the response of a linear oscillator in closed form."""
    blocks = scene(tmp_path, ALL)
    model, *_ = asked(tmp_path, blocks)
    omega, force = 24.0, 0.3
    flow, frequency = model.return_map(), np.array([omega])
    last = swings(flow, swept(flow, frequency, force, 60), frequency, force)
    found = 0.5 * np.ptp(last)
    linear = STRENGTH * force / abs(OMEGA**2 - omega**2 + 2j * DAMPING * omega)
    assert found == pytest.approx(linear, rel=5e-3)


def test_nothing_recorded_or_nothing_known_is_said(tmp_path):
    *_, answer, _ = asked(tmp_path, scene(tmp_path, ("train", "test")))
    with pytest.raises(Unsupported, match="no motion under a signal was recorded"):
        answer()
    *_, answer, _ = asked(tmp_path, scene(tmp_path, ("train", "test", "forced")))
    with pytest.raises(Unsupported, match="the load of this scene is not known"):
        answer()
    both = scene(tmp_path, ALL, forcing={"load": [1.0]})
    with pytest.raises(
        DataError, match="forcing.load is given, and a recording has the role calib"
    ):
        asked(tmp_path, both)


def test_a_signal_that_is_zero_tells_nothing(tmp_path):
    model, *_ = asked(tmp_path, scene(tmp_path, ALL))
    still = replace(model.calibration, signal=0.0 * model.calibration.signal)
    with pytest.raises(Unsupported, match="does not move the coordinates"):
        still.strength(model.rom, model.load)
