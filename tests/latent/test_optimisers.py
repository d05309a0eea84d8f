"""Adam against torch's, SOAP against what defines it."""

import numpy as np
import pytest
import torch

from vibrom.latent.optimisers import OPTIMISERS, Adam, Soap

SHAPES = [torch.Size((6, 4)), torch.Size((1, 6)), torch.Size((4, 6))]
SIZE = sum(shape.numel() for shape in SHAPES)


def gradients(count: int) -> torch.Tensor:
    return torch.randn(count, SIZE, generator=torch.Generator().manual_seed(3), dtype=torch.float64)


def rate(value: float) -> torch.Tensor:
    return torch.tensor(value, dtype=torch.float64)


def test_adam_is_torchs_adam():
    ours, theirs = (
        torch.ones(SIZE, dtype=torch.float64),
        torch.ones(SIZE, dtype=torch.float64, requires_grad=True),
    )
    adam, reference = Adam(ours, SHAPES), torch.optim.Adam([theirs], lr=0.1)
    for gradient in gradients(20):
        theirs.grad = gradient.clone()
        adam.step(gradient, rate(0.1))
        reference.step()
    assert torch.allclose(ours, theirs.detach(), rtol=1e-12, atol=0)


def test_soap_before_its_first_turn_is_adam():
    one, two = torch.ones(SIZE, dtype=torch.float64), torch.ones(SIZE, dtype=torch.float64)
    soap, adam = Soap(one, SHAPES), Adam(two, SHAPES, betas=(0.9, 0.95))
    for gradient in gradients(4):
        soap.step(gradient, rate(0.1))
        adam.step(gradient, rate(0.1))
    assert torch.allclose(one, two, rtol=1e-12, atol=0)


def test_turns_end_in_the_eigenvectors_of_the_averaged_squares():
    soap = Soap(torch.zeros(SIZE, dtype=torch.float64), SHAPES)
    found = gradients(12)
    for gradient in found:
        soap.step(gradient, rate(0.0))
    for _ in range(3000):
        soap.turn()
    first = found[:, : SHAPES[0].numel()].reshape(-1, *SHAPES[0]).numpy()
    weights = 0.05 * 0.95 ** np.arange(len(first))[::-1]
    for side, squares in enumerate(
        (first @ first.transpose(0, 2, 1), first.transpose(0, 2, 1) @ first)
    ):
        expected = np.tensordot(weights, squares, 1)
        basis = soap.bases[0, side].numpy()
        # Each turn gains a factor of the ratio of neighbouring eigenvalues; the closest two here
        # have 0.976, and 0.976^3000 is nothing.
        turned = basis.T @ expected @ basis
        assert np.allclose(
            turned, np.diag(np.linalg.eigvalsh(expected)[::-1]), atol=1e-9 * np.trace(expected)
        )


def descend(name: str, top: float) -> float:
    """|A W B - 1|^2 after 300 steps, for A and B of condition 10 with axes that lie askew."""
    random = np.random.default_rng(0)
    turn = [np.linalg.qr(random.standard_normal((8, 8)))[0] for _ in range(4)]
    a, b = (
        torch.tensor(left @ np.diag(np.logspace(0, -1, 8)) @ right)
        for left, right in (turn[:2], turn[2:])
    )
    vector = torch.zeros(64, dtype=torch.float64)
    optimiser = OPTIMISERS[name](vector, [torch.Size((8, 8))])
    for step in range(300):
        residual = a @ vector.view(8, 8) @ b - torch.eye(8, dtype=torch.float64)
        optimiser.step((2.0 * a.T @ residual @ b.T).flatten(), rate(top * (1.0 - step / 300)))
        if optimiser.every and (step + 1) % optimiser.every == 0:
            optimiser.turn()
    return float((a @ vector.view(8, 8) @ b - torch.eye(8, dtype=torch.float64)).square().sum())


def test_soap_sees_axes_that_adam_does_not():
    rates = np.logspace(-2, 2, 9)
    soap, adam = (min(descend(name, top) for top in rates) for name in ("soap", "adam"))
    assert soap < 1e-3 * adam  # 9e-8 against 0.18


@pytest.mark.parametrize("name", sorted(OPTIMISERS))
def test_the_state_is_all_that_is_remembered(name):
    """Two halves with the state carried over are the whole, bit for bit."""
    whole, half = torch.ones(SIZE), torch.ones(SIZE)
    one, two = OPTIMISERS[name](whole, SHAPES), OPTIMISERS[name](half, SHAPES)
    for step, gradient in enumerate(gradients(12).float()):
        if step == 6:
            kept, two = two.state, OPTIMISERS[name](half, SHAPES)
            for key, value in two.state.items():
                value.copy_(kept[key])
        for optimiser in (one, two):
            optimiser.step(gradient, rate(0.1))
            if step % 2:
                optimiser.turn()
    assert torch.equal(whole, half)
