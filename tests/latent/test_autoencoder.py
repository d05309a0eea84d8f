"""Time derivatives through the network, and the same network in NumPy."""

import numpy as np
import pytest
import torch

from vibrom.latent.autoencoder import ACTIVATIONS, SLOPE_AT_REST, Autoencoder, monomials, network, tangent
from vibrom.latent.autoencoder_rom import activate, slope_at_rest
from vibrom.latent.autoencoder_rom import network as network_in_numpy
from vibrom.latent.polynomial import exponents
from vibrom.latent.polynomial import monomials as monomials_in_numpy

SIZES = (7, 6, 5, 2)


def draw(seed=0):
    generator = torch.Generator().manual_seed(seed)
    shape = Autoencoder(SIZES, "silu")
    weights = shape.initial(generator)
    return weights[: len(SIZES) - 1], torch.randn(3, 11, SIZES[0], generator=generator, dtype=torch.float64)


@pytest.mark.parametrize("activation", sorted(ACTIVATIONS))
def test_derivatives_equal_forward_mode_twice(activation):
    weights, (y, first, second) = draw()

    def value(at):
        return network(at[None], weights, activation)[0]

    def slope(at, along):
        return torch.func.jvp(plain, (at,), (along,))[1]

    def plain(at):
        for weight in weights[:-1]:
            at = ACTIVATIONS[activation](at @ weight.T)[0]
        return at @ weights[-1].T

    bend = torch.func.jvp(slope, (y, first), (first, second))[1]
    stack = network(torch.stack([y, first, second]), weights, activation)
    for ours, theirs in zip(stack, (value(y), slope(y, first), bend)):
        assert torch.allclose(ours, theirs, atol=1e-10, rtol=0)


@pytest.mark.parametrize("activation", sorted(ACTIVATIONS))
@pytest.mark.parametrize("channels", [1, 2, 3])
def test_gradient_equals_differences(activation, channels):
    weights, stack = draw()
    # ELU's second derivative jumps at zero; a random draw stays clear of it by more than the step of the differences.
    weights = [weight.requires_grad_() for weight in weights]
    assert torch.autograd.gradcheck(lambda y, *w: network(y, list(w), activation), (stack[:channels].requires_grad_(), *weights), atol=1e-6)


@pytest.mark.parametrize("activation", sorted(ACTIVATIONS))
def test_numpy_equals_torch(activation):
    weights, stack = draw()
    arrays = [weight.numpy() for weight in weights]
    ours = network_in_numpy(arrays, np.zeros((SIZES[-1], SIZES[0])), activation, stack.numpy(), curved=True)
    assert np.allclose(ours, network(stack, weights, activation).numpy(), atol=1e-14)
    assert np.allclose(slope_at_rest(arrays, activation), tangent(weights, activation).numpy(), atol=1e-15)
    assert activate(activation, np.zeros(1), 1)[1][0] == SLOPE_AT_REST[activation]


def test_fixed_tangent_is_the_decoders_slope_at_rest():
    generator = torch.Generator().manual_seed(1)
    column = torch.randn(SIZES[0], SIZES[-1], generator=generator, dtype=torch.float64)
    shape = Autoencoder(SIZES, "silu", column.T.clone(), column, fixed_tangent=True)
    weights = shape.initial(generator)
    rest = torch.zeros(1, SIZES[-1], dtype=torch.float64)
    for axis, along in enumerate(torch.eye(SIZES[-1], dtype=torch.float64)):
        slope = shape.decode(torch.stack([rest, along[None]]), weights)[1][0]
        assert torch.allclose(slope, column[:, axis], atol=1e-14)


def test_monomials_equal_numpy():
    y = torch.randn(9, 4, dtype=torch.float64)
    powers = exponents(4, 1, 4)
    assert np.allclose(monomials(y, powers).numpy(), monomials_in_numpy(y.numpy(), powers), atol=1e-14)


def test_initial_weights_follow_the_seed():
    shape = Autoencoder(SIZES, "elu")
    one, two, other = (shape.initial(torch.Generator().manual_seed(seed)) for seed in (3, 3, 4))
    assert all(torch.equal(a, b) for a, b in zip(one, two))
    assert not torch.equal(one[0], other[0])
    assert [tuple(weight.shape) for weight in one] == [(6, 7), (5, 6), (2, 5), (5, 2), (6, 5), (7, 6)]
