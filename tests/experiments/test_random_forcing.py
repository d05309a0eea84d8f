"""Spectra of a linear body under noise, against its frequency response."""

from dataclasses import replace

import numpy as np
import pytest
import two_dofs

from vibrom.experiments.random_forcing import RandomForcing

ASKED = RandomForcing(forcing=0.1, lowest=0.2, highest=3.0, periods=400, settle=60, windows=7)


@pytest.fixture(scope="module")
def answer():
    return ASKED.ask(two_dofs.reduced(), two_dofs.given())


def test_the_spectrum_of_a_linear_body_is_that_of_the_noise_times_its_response(answer):
    """S_q = |H|^2 S_u within what Welch's estimate is known to: averages over 8 realisations of 7
    windows each scatter by 1.06/sqrt(56) (Hann's windows that overlap by half); a window of 100
    periods is long beside the memory of the body, of 5 periods, and biases little.
    """
    frequency = answer["angular_frequency"].values
    inside = (frequency > 0.25 * two_dofs.DAMPED) & (frequency < 2.9 * two_dofs.DAMPED)
    density = answer["spectral_density"].values[1, inside]  # of the mass of `swing`
    noise = 0.1**2 / (2.8 * two_dofs.DAMPED)
    ratio = density / (noise * two_dofs.swing(frequency[inside]) ** 2)
    sigma = 1.06 / np.sqrt(56)
    # Half the neighbours are independent of one another.
    assert abs(ratio.mean() - 1.0) < 4 * sigma / np.sqrt(0.5 * len(ratio))
    assert np.mean(np.abs(ratio - 1.0) < 2 * sigma) > 0.92
    assert ratio.std() == pytest.approx(sigma, rel=0.25)


def test_the_variance_is_the_area_of_the_spectrum(answer):
    """Up to the scatter of a resonance's energy in 8 realisations, which both know."""
    area = np.trapezoid(answer["spectral_density"].values, answer["angular_frequency"].values)
    variance = (answer["deviation"].values ** 2).mean(axis=0)
    np.testing.assert_allclose(area, variance, rtol=0.1)


def test_the_same_seeds_give_the_same_bytes_and_others_do_not():
    short = replace(ASKED, periods=20, settle=0)
    first, again, later = (
        asked.ask(two_dofs.reduced(), two_dofs.given())
        for asked in (short, short, replace(short, seed=1))
    )
    for name in ("spectral_density", "deviation"):
        assert again[name].values.tobytes() == first[name].values.tobytes()
    assert not np.isclose(*first["deviation"].values[:2, 0], rtol=1e-6)
    assert first["realisation"].values.tolist() == list(range(8))
    assert later["realisation"].values.tolist() == list(range(1, 9))
