"""Time derivatives through the network, their gradients, and the same network in NumPy."""

from typing import get_args

import numpy as np
import pytest
import torch

from vibrom.latent.autoencoder import (
    ACTIVATIONS,
    SLOPE_AT_REST,
    Autoencoder,
    Polynomial,
    backward,
    forward,
    tangent,
    tangent_backward,
)
from vibrom.latent.networks import Activation, Network, activate
from vibrom.latent.polynomial import exponents
from vibrom.latent.polynomial import monomials as monomials_in_numpy

SIZES = (7, 6, 5, 2)


def draw(seed=0):
    generator = torch.Generator().manual_seed(seed)
    shape = Autoencoder(SIZES, "silu")
    weights = shape.initial(generator)
    return weights[: len(SIZES) - 1], torch.randn(
        3, 11, SIZES[0], generator=generator, dtype=torch.float64
    )


SCALAR = {
    "elu": torch.nn.functional.elu,
    "silu": torch.nn.functional.silu,
    "tanh": torch.tanh,
    "softplus": lambda a: torch.nn.functional.softplus(a) - np.log(2.0),
}


def plain(y, weights, activation):
    """The network as anyone would write it."""
    for weight in weights[:-1]:
        y = SCALAR[activation](y @ weight.T)
    return y @ weights[-1].T


def taylor(stack, weights, activation):
    """Value, first and second time derivative by forward-mode differentiation, once and twice."""
    y, first, second = stack

    def slope(at, along):
        return torch.func.jvp(lambda at: plain(at, weights, activation), (at,), (along,))[1]

    return torch.stack(
        [
            plain(y, weights, activation),
            slope(y, first),
            torch.func.jvp(slope, (y, first), (first, second))[1],
        ]
    )


def test_every_activation_that_is_offered_is_there():
    assert set(ACTIVATIONS) == set(get_args(Activation))


@pytest.mark.parametrize("activation", sorted(ACTIVATIONS))
def test_derivatives_equal_forward_mode_twice(activation):
    weights, stack = draw()
    assert torch.allclose(
        forward(stack, weights, activation)[0],
        taylor(stack, weights, activation),
        atol=1e-10,
        rtol=0,
    )
    assert torch.allclose(
        forward(stack[:1], weights, activation)[0][0],
        plain(stack[0], weights, activation),
        atol=1e-12,
        rtol=0,
    )


@pytest.mark.parametrize("activation", sorted(ACTIVATIONS))
@pytest.mark.parametrize("channels", [1, 3])
def test_gradient_equals_automatic_differentiation(activation, channels):
    weights, stack = draw()
    stack = stack[:channels].requires_grad_()
    weights = [weight.requires_grad_() for weight in weights]
    theirs = (
        plain(stack[0], weights, activation)[None]
        if channels == 1
        else taylor(stack, weights, activation)
    )
    along = torch.randn(
        theirs.shape, generator=torch.Generator().manual_seed(2), dtype=torch.float64
    )
    expected = torch.autograd.grad(theirs, [stack, *weights], along)
    with torch.no_grad():
        _, tape = forward(stack, weights, activation)
        slopes = [torch.empty_like(weight) for weight in weights]
        inward = backward(along, weights, tape, slopes, inwards=True)
    for ours, theirs in zip([inward, *slopes], expected, strict=True):
        assert torch.allclose(ours, theirs, atol=1e-10, rtol=0)


def test_gradient_of_the_tangent_equals_automatic_differentiation():
    weights, _ = draw()
    weights = [weight.requires_grad_() for weight in weights]
    along = torch.randn(
        weights[-1].shape[0],
        weights[0].shape[1],
        generator=torch.Generator().manual_seed(2),
        dtype=torch.float64,
    )
    at_rest = torch.func.jacrev(lambda y: plain(y, weights, "silu"))(
        torch.zeros(weights[0].shape[1], dtype=torch.float64)
    )
    assert torch.allclose(tangent(weights, "silu"), at_rest, atol=1e-14)
    expected = torch.autograd.grad(at_rest, weights, along)
    slopes = [torch.zeros_like(weight) for weight in weights]
    with torch.no_grad():
        tangent_backward(along, weights, "silu", slopes)
    assert all(
        torch.allclose(ours, theirs, atol=1e-13)
        for ours, theirs in zip(slopes, expected, strict=True)
    )


@pytest.mark.parametrize("activation", sorted(ACTIVATIONS))
def test_numpy_equals_torch(activation):
    weights, stack = draw()
    arrays = [weight.numpy() for weight in weights]
    ours = Network(arrays, np.zeros((SIZES[-1], SIZES[0])), activation)
    theirs = forward(stack, weights, activation)[0].numpy()
    assert np.allclose(ours.motion(stack.numpy()), theirs, atol=1e-14)
    assert np.allclose(ours.along(stack.numpy()[:2]), theirs[:2], atol=1e-14)
    assert np.allclose(ours.slope_at_rest(), tangent(weights, activation).numpy(), atol=1e-15)
    assert activate(activation, np.zeros(1), 1)[1][0] == SLOPE_AT_REST[activation]


def test_fixed_tangent_is_the_decoders_slope_at_rest():
    generator = torch.Generator().manual_seed(1)
    column = torch.randn(SIZES[0], SIZES[-1], generator=generator, dtype=torch.float64)
    shape = Autoencoder(SIZES, "silu", column.T.clone(), column, fixed_tangent=True)
    weights = shape.initial(generator)
    rest = torch.zeros(1, SIZES[-1], dtype=torch.float64)
    for axis, along in enumerate(torch.eye(SIZES[-1], dtype=torch.float64)):
        slope = shape.decode(torch.stack([rest, along[None], rest]), weights)[0][1, 0]
        assert torch.allclose(slope, column[:, axis], atol=1e-14)


def test_monomials_equal_numpy_and_their_slopes_differences():
    y = torch.randn(9, 4, generator=torch.Generator().manual_seed(0), dtype=torch.float64)
    powers = exponents(4, 1, 4)
    polynomial = Polynomial(powers, torch.device("cpu"))
    values, slopes = polynomial.monomials(y)
    assert np.allclose(values.numpy(), monomials_in_numpy(y.numpy(), powers), atol=1e-14)
    # the differences' own error is the square of that, times third derivatives of some tens
    step = 1e-5
    for axis, along in enumerate(step * np.eye(4)):
        differences = (
            monomials_in_numpy(y.numpy() + along, powers)
            - monomials_in_numpy(y.numpy() - along, powers)
        ) / (2 * step)
        assert np.allclose(slopes[axis].numpy(), differences, atol=1e-7)


def test_initial_weights_follow_the_seed():
    shape = Autoencoder(SIZES, "elu")
    one, two, other = (shape.initial(torch.Generator().manual_seed(seed)) for seed in (3, 3, 4))
    assert all(torch.equal(a, b) for a, b in zip(one, two))
    assert not torch.equal(one[0], other[0])
    assert [tuple(weight.shape) for weight in one] == [
        (6, 7),
        (5, 6),
        (2, 5),
        (5, 2),
        (6, 5),
        (7, 6),
    ]
