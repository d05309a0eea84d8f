"""A captured step trains like the step itself, and its rehearsals leave no trace."""

from contextlib import nullcontext
from types import SimpleNamespace

import numpy as np
import pytest
import torch

from vibrom.latent import training as loop
from vibrom.latent.autoencoder import Autoencoder
from vibrom.latent.graphs import captured
from vibrom.latent.learner import Dynamics
from vibrom.latent.polynomial import exponents
from vibrom.models.training import Clock

DYNAMICS = Dynamics(np.array([[-1.0, -0.02]]), exponents(2, 2, 3), 0.0, 1.0, 1.0, 0.1, 0.0)
SAMPLES = np.random.default_rng(0).standard_normal((3, 40, 5))


def trained(device="cpu", **changes):
    """Weights and Xi after 30 epochs."""
    settings = dict(
        epochs=30,
        batch=16,
        shuffle=True,
        learning_rate=1e-2,
        profile="one_cycle",
        precision="float64",
        optimiser="soap",
    )
    weights, found = loop.train(
        Autoencoder((5, 8, 1), "silu"),
        DYNAMICS,
        loop.Schedule(**settings | changes),
        SAMPLES,
        seed=3,
        device=torch.device(device),
        monitor=Clock(),
    )
    return np.concatenate([part.ravel() for part in (*weights, found)])


@pytest.fixture
def pretended(monkeypatch):
    """`captured` as on a GPU, with a graph that calls the step; gives the list of the steps
    captured.
    """
    steps = []
    stream = SimpleNamespace(wait_stream=lambda other: None)
    for name, stand_in in (
        ("Stream", lambda: stream),
        ("current_stream", lambda: stream),
        ("stream", nullcontext),
        ("graph", nullcontext),
        ("device", nullcontext),
    ):
        monkeypatch.setattr(torch.cuda, name, stand_in)

    def capture(step, changed, device):
        steps.append(step)
        monkeypatch.setattr(torch.cuda, "CUDAGraph", lambda: SimpleNamespace(replay=step))
        return captured(step, changed, SimpleNamespace(type="cuda"))

    monkeypatch.setattr(loop, "captured", capture)
    return steps


@pytest.mark.parametrize(
    "changes",
    [{}, {"optimiser": "adam"}, {"batch": 0, "shuffle": False}],
    ids=["soap", "adam", "all at once"],
)
def test_rehearsals_leave_no_trace(changes, request):
    """All that a step changes and reads again is put back: else the weights would differ."""
    plain = trained(**changes)
    steps = request.getfixturevalue("pretended")
    assert np.array_equal(trained(**changes), plain)
    assert len(steps) == (
        1 if changes.get("batch") == 0 else 2
    )  # one for each size of a batch: 16, and the 8 that are left


def test_on_a_cpu_the_step_is_called_as_it_is():
    def step():
        raise AssertionError("must not be rehearsed")

    assert captured(step, [], torch.device("cpu")) is step


@pytest.mark.skipif(not torch.cuda.is_available(), reason="no GPU")
@pytest.mark.parametrize(
    "changes",
    [{}, {"optimiser": "adam"}, {"batch": 0, "shuffle": False}],
    ids=["soap", "adam", "all at once"],
)
def test_a_gpu_learns_what_a_cpu_learns(changes):
    """In float64 sums in another order differ by 1e-15, which 90 steps of well-conditioned training
    amplify little.
    """
    np.testing.assert_allclose(
        trained("cuda", **changes), trained("cpu", **changes), rtol=1e-6, atol=1e-8
    )
