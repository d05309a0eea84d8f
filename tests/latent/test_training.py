"""The training loop: resumed equals uninterrupted, same seed same bytes, stops on a non-finite loss."""

import numpy as np
import pytest
import torch

from vibrom.latent import training as loop
from vibrom.latent.autoencoder import Autoencoder
from vibrom.latent.polynomial import exponents
from vibrom.rom import Monitor, TrainingDiverged

SHAPE = Autoencoder((5, 8, 1), "silu")
DYNAMICS = loop.Dynamics(np.array([[-1.0, -0.02]]), exponents(2, 2, 3), 0.0, 1.0, 1.0, 0.1, 0.0)


@pytest.fixture(autouse=True)
def one_thread():
    before = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(before)


def motion(samples=64):
    tau = np.linspace(0.0, 20.0, samples)
    decay = np.exp((-0.01 + 1j) * tau)
    z = np.stack([decay.real, (decay * (-0.01 + 1j)).real, (decay * (-0.01 + 1j) ** 2).real])
    return z[..., None] * np.array([1.0, 0.5, -0.3, 0.2, 0.1])


def schedule(**changes):
    settings = dict(epochs=30, batch=16, shuffle=True, learning_rate=1e-2, rate="one_cycle", precision="float32")
    return loop.Schedule(**settings | changes)


class Kept(Monitor):
    """Keeps what it is told, and stops the training after so many checkpoints."""

    def __init__(self, state=None, stop_after=None):
        self.state, self.stop_after, self.rows = state, stop_after, []

    def epoch(self, epoch, epochs, losses):
        self.rows.append((epoch, losses))

    def restore(self):
        return self.state

    def checkpoint(self, state):
        self.state = state
        self.stop_after = None if self.stop_after is None else self.stop_after - 1
        if self.stop_after == 0:
            raise KeyboardInterrupt


def train(monitor=None, dynamics=DYNAMICS, data=None, seed=7, label="", **changes):
    data = motion() if data is None else data
    return loop.train(SHAPE, dynamics, schedule(**changes), data, motion(40), seed=seed, device=torch.device("cpu"),
                      monitor=monitor or Monitor(), label=label)


def same(one, two):
    return all(a.tobytes() == b.tobytes() for a, b in zip(one, two, strict=True))


@pytest.mark.parametrize("changes", [{}, {"batch": 0, "shuffle": False, "rate": "constant", "precision": "float64"}])
def test_resumed_equals_uninterrupted(monkeypatch, changes):
    whole = Kept()
    expected = train(whole, **changes)
    monkeypatch.setattr(loop, "CHECKPOINT_SECONDS", -1.0)
    first = Kept(stop_after=13)
    with pytest.raises(KeyboardInterrupt):
        train(first, **changes)
    assert all(isinstance(value, (np.ndarray, int, float, str)) for value in first.state.values())
    assert not any(value.dtype == object for value in first.state.values() if isinstance(value, np.ndarray))
    second = Kept(state=first.state)
    assert same(train(second, **changes), expected)
    assert second.rows == whole.rows


def test_a_checkpoint_of_other_settings_is_not_taken_up(monkeypatch):
    monkeypatch.setattr(loop, "CHECKPOINT_SECONDS", -1.0)
    other = Kept()
    train(other, label="other")
    assert same(train(Kept(state=other.state), label="this"), train(label="this"))


def test_same_seed_same_bytes():
    assert same(train(), train())
    assert not same(train(), train(seed=8))


def test_non_finite_loss_stops_with_the_epoch():
    data = motion()
    data[0, 3] = np.inf
    with pytest.raises(TrainingDiverged, match="epoch 1 of 30"):
        train(data=data)


def test_history_is_thin_and_has_every_term():
    monitor = Kept()
    train(monitor, epochs=700, batch=0)
    assert len(monitor.rows) <= 301
    assert monitor.rows[-1][0] == 700
    terms = {"total", "reconstruction", "acceleration_full", "acceleration_reduced"}
    assert set(monitor.rows[0][1]) == {f"{role}_{term}" for role in ("train", "test") for term in terms}
    assert monitor.rows[-1][1]["train_total"] < 0.1 * monitor.rows[0][1]["train_total"]
