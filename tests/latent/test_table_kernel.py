"""Tables of force maps against the networks that they stand for."""

from dataclasses import replace
from typing import get_args

import numpy as np
import pytest

from tests.latent.test_kernels import DOFS, autoencoder, values
from vibrom.kernels.lanes import WIDTH
from vibrom.latent.force_rules import ForceRule
from vibrom.latent.table_kernel import ERROR, _table, evaluated, tabulated
from vibrom.models.rollout import LIMIT
from vibrom.solvers.reduced.field import Kernel, field_kernel


@field_kernel
def _sine(z, numbers, index, work, out):
    for w in range(WIDTH):
        out[0, w] = 0.0
        out[1, w] = np.sin(numbers[0] * z[0, w])


def sine(frequency):
    """a = sin(frequency z)."""
    return Kernel(_sine, np.array([float(frequency)]), np.zeros(1, np.int64), 0, 2)


def test_a_smooth_map_becomes_a_table_that_is_constant_beyond_its_ends():
    table = tabulated(sine(3.0), 2.0)
    z = np.linspace(-2.0, 2.0, 10001)
    assert table.function is _table
    np.testing.assert_allclose(evaluated(table, z), np.sin(3.0 * z), atol=2 * ERROR)
    ends = evaluated(table, np.array([-1e300, -7.0, 7.0, np.inf]))
    np.testing.assert_allclose(ends, np.sin(6.0) * np.array([-1, -1, 1, 1]), atol=2 * ERROR)


def test_what_is_no_number_stays_none_and_lanes_do_not_see_one_another():
    table, z = tabulated(sine(3.0), 2.0), np.linspace(-1.0, 1.0, 16)
    spoilt = z.copy()
    spoilt[[3, 9]] = np.nan
    clean, mixed = evaluated(table, z), evaluated(table, spoilt)
    assert np.isnan(mixed[[3, 9]]).all()
    np.testing.assert_array_equal(np.delete(clean, [3, 9]), np.delete(mixed, [3, 9]))


def test_a_map_that_is_not_smooth_enough_stays_as_it_is():
    rough = sine(5e4)
    assert tabulated(rough, 2.0) is rough


@pytest.mark.parametrize("rule", get_args(ForceRule))
@pytest.mark.parametrize("beyond", ["network", "tangent"])
def test_models_of_one_position_have_tables_as_far_as_a_run_goes(rule, beyond):
    """The tangent's is constant beyond the training range, but where the encoder is asked too."""
    rom = replace(autoencoder(rule=rule), decoder_beyond=beyond)
    p, far = np.arange(DOFS) - 3.0, LIMIT * rom.reach[0]
    z = np.zeros((4000, 2))
    z[:, 0] = np.linspace(-far, far, 4000)
    force, right = rom.field(p).force, rom.force_map(z, p)
    assert force.function is _table
    np.testing.assert_allclose(values(force, z), right, atol=1e-12 * np.abs(right).max(), rtol=0)


def test_models_of_two_positions_have_none():
    assert autoencoder(2).field(np.ones(DOFS)).force.function is not _table
