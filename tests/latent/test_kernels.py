"""Compiled vector fields against the numpy functions of the same models, and their elementary
functions against SciPy's.
"""

from dataclasses import replace
from itertools import product
from typing import get_args

import numpy as np
import pytest
from numba import njit
from scipy.sparse import csr_matrix, diags
from scipy.special import expit

from vibrom.kernels.lanes import WIDTH, get, put
from vibrom.latent.autoencoder_rom import AutoencoderRom, DecoderBeyond
from vibrom.latent.elementary import CODES, activate
from vibrom.latent.force_rules import ForceRule
from vibrom.latent.networks import Activation
from vibrom.latent.polynomial import exponents, monomials
from vibrom.latent.polynomial_kernel import polynomial_kernel
from vibrom.models.rom import rom_from_dataset
from vibrom.models.training import Unsupported

DOFS = 9
RULES, BEYOND, ACTIVATIONS = (get_args(kind) for kind in (ForceRule, DecoderBeyond, Activation))


def values(kernel, z):
    """(b, r) of a kernel at z (b, r), b a multiple of eight; scratch that nobody wrote is NaN."""
    out, work = np.empty((z.shape[1], 8)), np.full(8 * max(kernel.rows, 1), np.nan)
    found = []
    for part in z.reshape(-1, 8, z.shape[1]):
        kernel.function(np.ascontiguousarray(part.T), kernel.numbers, kernel.index, work, out)
        found.append(out.T.copy())
    return np.concatenate(found)


@pytest.mark.parametrize(
    "r, lowest, highest", [(1, 0, 13), (2, 1, 13), (3, 2, 5), (4, 1, 5), (6, 0, 3)]
)
def test_polynomials(r, lowest, highest):
    rng, powers = np.random.default_rng(r), exponents(r, lowest, highest)
    powers = powers[
        rng.permutation(len(powers))[: max(2, 2 * len(powers) // 3)]
    ]  # gaps, and no order
    coefficients = rng.standard_normal((r, len(powers))) * (
        rng.uniform(size=(r, len(powers))) < 0.7
    )
    z, scale = rng.uniform(-3, 3, (40, r)), rng.uniform(0.5, 2.0, r)
    terms = monomials(z / scale, powers)
    # Sums of up to 125 terms, each a product of up to 13: two hundred roundings of the largest sum
    # of sizes.
    bound = 200 * np.finfo(float).eps * (np.abs(terms) @ np.abs(coefficients).T)
    assert (
        np.abs(values(polynomial_kernel(scale, powers, coefficients), z) - terms @ coefficients.T)
        <= bound
    ).all()


def test_elementary_functions_anywhere():
    @njit
    def both(code, a, value, slope):
        for i in range(len(a)):
            s, ds = activate(code, get(a, i, WIDTH))
            put(value, i, s)
            put(slope, i, ds)

    size = np.logspace(-20, 3, 2000)
    a = np.concatenate([-size[::-1], [0.0, np.nan], size, np.linspace(-40, 40, 3998)]).reshape(
        -1, 8
    )
    value, slope = np.empty_like(a), np.empty_like(a)
    with np.errstate(all="ignore"):
        s = expit(a)
        right = {
            "silu": (a * s, s * (1.0 + a * expit(-a))),
            "elu": (np.where(a > 0.0, a, np.expm1(a)), np.exp(np.minimum(a, 0.0))),
            "tanh": (np.tanh(a), np.cosh(a) ** -2.0),
            "softplus": (np.logaddexp(0.0, a) - np.log(2.0), s),
        }
    for name, code in CODES.items():
        both(code, a, value, slope)
        # A few units in the last place of one, or of the value where that is larger; NaN stays NaN.
        np.testing.assert_allclose(value, right[name][0], rtol=2e-15, atol=4e-16, err_msg=name)
        np.testing.assert_allclose(slope, right[name][1], rtol=2e-15, atol=1e-15, err_msg=name)


def autoencoder(
    latent=1,
    rank=5,
    activation="silu",
    rule="decoder_mass",
    first_order=False,
    hidden=(7, 10),
    seed=0,
):
    rng, width = np.random.default_rng(seed), rank or DOFS
    sizes = np.array([width, *hidden, latent])
    count = int((sizes[1:] * sizes[:-1]).sum())
    mass = diags([0.1, 1.0, 0.1], [-1, 0, 1], shape=(DOFS, DOFS))
    order = 3
    rows = 2 * latent if first_order else latent
    return AutoencoderRom(
        np.full(2 * latent, 2.0),
        sizes,
        0.4 * rng.standard_normal(2 * count),
        rng.standard_normal((latent, width)),
        rng.standard_normal((width, latent)),
        np.linalg.qr(rng.standard_normal((DOFS, rank)))[0] if rank else None,
        0.03,
        25.0,
        rng.standard_normal((rows, len(exponents(2 * latent, 1, order)))),
        csr_matrix(mass),
        order,
        activation,
        rule,
    )


@pytest.mark.parametrize(
    "latent, rank, first_order", [(1, 5, False), (1, 0, True), (2, 5, True), (3, 0, False)]
)
def test_autoencoders(latent, rank, first_order):
    p, rng = np.random.default_rng(3).standard_normal(DOFS), np.random.default_rng(4)
    z = rng.uniform(-3, 3, (40, 2 * latent)) * np.repeat([1.0, 25.0], latent)
    for activation in ACTIVATIONS:
        for rule, beyond in product(RULES, BEYOND):  # the range ends at two
            rom = replace(
                autoencoder(latent, rank, activation, rule, first_order), decoder_beyond=beyond
            )
            field = rom.field(p)
            for kernel, right in ((field.drift, rom.drift(z)), (field.force, rom.force_map(z, p))):
                # Gram matrices of three tangents lose at most some hundred of condition here.
                np.testing.assert_allclose(
                    values(kernel, z),
                    right,
                    rtol=0,
                    atol=1e-12 * np.abs(right).max(),
                    err_msg=f"{activation} {rule} {beyond}",
                )


def test_one_hidden_layer_and_many():
    p, z = np.arange(DOFS) - 3.0, np.random.default_rng(4).uniform(-2, 2, (8, 2))
    for hidden in ((), (4,), (5, 6, 7, 11)):
        for rule in RULES:
            rom = autoencoder(hidden=hidden, rule=rule)
            right = rom.force_map(z, p)
            np.testing.assert_allclose(
                values(rom.field(p).force, z),
                right,
                rtol=0,
                atol=1e-12 * np.abs(right).max(),
                err_msg=f"{hidden} {rule}",
            )


def test_some_displacements_are_rows_of_all():
    for rom in (autoencoder(2), autoencoder(1, 0)):
        z, dofs = np.random.default_rng(0).standard_normal((6, 2 * rom.latent)), np.array([7, 2])
        np.testing.assert_allclose(rom.displacement(z), rom.decode(z)[:, :DOFS], atol=1e-15)
        np.testing.assert_allclose(rom.displacement(z, dofs), rom.decode(z)[:, dofs], atol=1e-15)


def test_a_decoder_goes_on_along_its_tangent():
    for latent in (1, 2):
        free = autoencoder(latent)
        rom, step = replace(free, decoder_beyond="tangent"), 1e-6
        inside = np.random.default_rng(1).uniform(-2, 2, (20, 2 * latent))
        np.testing.assert_allclose(rom.decode(inside), free.decode(inside), rtol=1e-14, atol=1e-16)
        edge = inside.copy()
        edge[:, :latent] = 2.0 * np.sign(inside[:, :latent])
        out = np.zeros_like(edge)
        out[:, :latent] = edge[:, :latent] * np.random.default_rng(2).uniform(
            0.1, 1.0, (20, latent)
        )
        at = [rom.decode(edge + far * out) for far in (0.0, 1.0, 2.0)]
        slope = (free.decode(edge + step * out) - free.decode(edge - step * out))[:, :DOFS] / (
            2 * step
        )
        # The network's own derivative at the edge, by differences that are good to step^2;
        # velocities keep the tangent of the edge.
        np.testing.assert_allclose(
            (at[1] - at[0])[:, :DOFS], slope, atol=1e-8 * np.abs(slope).max()
        )
        np.testing.assert_allclose(
            (at[2] - at[0])[:, :DOFS], 2 * (at[1] - at[0])[:, :DOFS], atol=1e-13
        )
        np.testing.assert_allclose(at[2][:, DOFS:], at[0][:, DOFS:], atol=1e-13)
        np.testing.assert_allclose(
            rom.displacement(edge + out), rom.decode(edge + out)[:, :DOFS], atol=1e-15
        )
        p = np.arange(DOFS) - 3.0
        np.testing.assert_allclose(
            rom.force_map(edge + out, p), free.force_map(edge, p), rtol=1e-12
        )
        back = rom_from_dataset(rom.to_dataset())
        np.testing.assert_array_equal(back.decode(edge + out), rom.decode(edge + out))


def test_a_lane_does_not_see_its_neighbours():
    rom, p = autoencoder(2, 5, rule="encoder"), np.ones(DOFS)
    z = np.random.default_rng(0).standard_normal((8, 4))
    spoilt = z.copy()
    spoilt[[1, 4]] = np.nan
    for kernel in (rom.field(p).drift, rom.field(p).force):
        clean, mixed = values(kernel, z), values(kernel, spoilt)
        assert (
            np.array_equal(clean[[0, 2, 3, 5, 6, 7]], mixed[[0, 2, 3, 5, 6, 7]])
            and np.isnan(mixed[[1, 4], 2:]).all()
        )


def test_without_a_mass_a_load_is_refused_and_a_decay_is_not():
    rom = replace(autoencoder(), mass=None)
    assert rom.field(None).force is None
    with pytest.raises(Unsupported, match="without a mass matrix"):
        rom.field(np.ones(DOFS))
