"""The training loop: its loss and gradient, resumed equals uninterrupted, same seed same bytes,
stops on a non-finite loss.
"""

import numpy as np
import pytest
import torch

from vibrom.latent import training as loop
from vibrom.latent.autoencoder import Autoencoder
from vibrom.latent.learner import Dynamics, Learner
from vibrom.latent.optimisers import OPTIMISERS
from vibrom.latent.polynomial import exponents
from vibrom.models.training import Clock, Monitor, TrainingDiverged

pytestmark = pytest.mark.usefixtures("one_thread")

SHAPE = Autoencoder((5, 8, 1), "silu")
DYNAMICS = Dynamics(np.array([[-1.0, -0.02]]), exponents(2, 2, 3), 0.0, 1.0, 1.0, 0.1, 0.0)


def motion(samples=64):
    tau = np.linspace(0.0, 20.0, samples)
    decay = np.exp((-0.01 + 1j) * tau)
    z = np.stack([decay.real, (decay * (-0.01 + 1j)).real, (decay * (-0.01 + 1j) ** 2).real])
    return z[..., None] * np.array([1.0, 0.5, -0.3, 0.2, 0.1])


def schedule(**changes):
    settings = {
        "epochs": 30,
        "batch": 16,
        "shuffle": True,
        "learning_rate": 1e-2,
        "profile": "one_cycle",
        "precision": "float32",
        "optimiser": "soap",
    }
    return loop.Schedule(**settings | changes)


class Kept(Monitor):
    """Keeps what it is told, and stops the training after so many checkpoints."""

    def __init__(self, state=None, stop_after=None):
        super().__init__()
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
    weights, found = loop.train(
        SHAPE,
        dynamics,
        schedule(**changes),
        data,
        seed=seed,
        device=torch.device("cpu"),
        monitor=monitor or Clock(),
        label=label,
    )
    return [*weights, found]


def same(one, two):
    return all(a.tobytes() == b.tobytes() for a, b in zip(one, two, strict=True))


def written_out(learner, weights, c, decoder_linear):
    """The loss of the module's docstring for silu, differentiated by torch; c (3, sample, k) of one
    latent coordinate.
    """
    dynamics, layers = learner.dynamics, len(learner.autoencoder.sizes) - 1

    def network(y, chosen):
        for weight in chosen[:-1]:
            y = torch.nn.functional.silu(y @ weight.T)
        return y @ chosen[-1].T

    def along(function, value, first, second):
        def slope(at, velocity):
            return torch.func.jvp(function, (at,), (velocity,))[1]

        return slope(value, first), torch.func.jvp(slope, (value, first), (first, second))[1]

    decoder = weights[layers : 2 * layers]
    column = decoder_linear - torch.func.jacrev(lambda z: network(z, decoder))(
        torch.zeros(1, dtype=c.dtype)
    )
    encode, decode = (
        lambda q: network(q, weights[:layers]) + q @ decoder_linear,
        lambda z: network(z, decoder) + z @ column.T,
    )
    z = encode(c[0])
    first, second = along(encode, *c)
    found = dynamics.gain * weights[-1]
    model = torch.cat([z, first], 1) @ torch.tensor(dynamics.linear).T
    model = model + sum(
        found[0, i] * (z[:, 0] ** int(a) * first[:, 0] ** int(b))[:, None]
        for i, (a, b) in enumerate(dynamics.powers)
    )
    apart = (c[2] - along(decode, z, first, model)[1]) @ torch.tensor(dynamics.norm).T
    parts = [
        (c[0] - decode(z)).square().sum(1).mean(),
        apart.square().sum(1).mean(),
        (second - model).square().sum(1).mean(),
    ]
    return torch.stack(
        [
            parts[0]
            + dynamics.full * parts[1]
            + dynamics.reduced * parts[2]
            + dynamics.sparsity * found.abs().sum(),
            *parts,
        ]
    )


def test_loss_and_gradient_equal_automatic_differentiation():
    column = torch.tensor([[1.0], [0.5], [-0.3], [0.2], [0.1]], dtype=torch.float64)
    shape = Autoencoder((5, 8, 6, 1), "silu", column.T.clone(), column, fixed_tangent=True)
    norm = np.random.default_rng(3).standard_normal((5, 5))
    dynamics = Dynamics(
        np.array([[-1.0, -0.02]]), exponents(2, 2, 3), 0.3, 3.0, 0.7, 0.2, 0.01, norm
    )
    learner = Learner(
        shape, dynamics, torch.float64, torch.device("cpu"), torch.Generator().manual_seed(0)
    )
    c = torch.tensor(motion())
    weights = [part.clone().requires_grad_() for part in learner.parts]
    expected = written_out(learner, weights, c, column)
    assert torch.allclose(learner.losses(c), expected, rtol=1e-12)
    gradient = torch.cat([part.flatten() for part in torch.autograd.grad(expected[0], weights)])
    assert torch.allclose(learner.gradient, gradient, atol=1e-12 * float(gradient.abs().max()))


@pytest.mark.parametrize("optimiser", sorted(OPTIMISERS))
@pytest.mark.parametrize("dynamics", [DYNAMICS, None])
def test_nothing_is_fetched_within_the_loop(optimiser, dynamics):
    """On torch's device without data any look at a value is an error."""
    device = torch.device("meta")
    learner = Learner(SHAPE, dynamics, torch.float32, device, torch.Generator().manual_seed(0))
    chosen = schedule(optimiser=optimiser, epochs=3)
    c = torch.empty(3, 64, 5, device=device)
    optimiser = OPTIMISERS[optimiser](learner.vector, learner.shapes)
    generator = torch.Generator().manual_seed(0)
    *_, (epoch, sums) = loop.epochs(learner, optimiser, chosen, c, generator)
    assert epoch == chosen.epochs
    with pytest.raises((RuntimeError, NotImplementedError)):
        sums.tolist()


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"batch": 0, "shuffle": False, "profile": "constant", "precision": "float64"},
        {"optimiser": "adam"},
    ],
)
def test_resumed_equals_uninterrupted(monkeypatch, changes):
    whole = Kept()
    expected = train(whole, **changes)
    monkeypatch.setattr(loop, "CHECKPOINT_SECONDS", -1.0)
    first = Kept(stop_after=13)
    with pytest.raises(KeyboardInterrupt):
        train(first, **changes)
    assert all(isinstance(value, (np.ndarray, int, float, str)) for value in first.state.values())
    assert not any(
        value.dtype == object for value in first.state.values() if isinstance(value, np.ndarray)
    )
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
    assert len(monitor.rows) <= loop.ROWS + 1
    assert monitor.rows[-1][0] == 700
    terms = {"total", "reconstruction", "acceleration_full", "acceleration_reduced"}
    assert set(monitor.rows[0][1]) == {f"train_{term}" for term in terms}
    assert monitor.rows[-1][1]["train_total"] < 0.1 * monitor.rows[0][1]["train_total"]
