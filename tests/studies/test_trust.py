"""The study of trust: exact models are trusted as far as is looked, wrong ones by hand."""

from dataclasses import replace

import numpy as np
import pytest
import two_dof_case
import two_dofs
import xarray as xr

from vibrom import studies
from vibrom.artefacts.data import variable
from vibrom.models.full_order import FullOrder

SETTINGS = {"amplitudes": [0.5, 1.0, 1.2], "tolerance": 0.01}
OFF = 0.06  # of the squared frequencies


@pytest.fixture(scope="module")
def made():
    """An exact model, one six percent too stiff, one that was not fitted."""
    exact = two_dofs.rom()
    stiffer = exact.dynamics.copy()
    stiffer[2:, :2] *= 1 + OFF
    wrong = two_dof_case.fit(replace(exact, dynamics=stiffer), "wrong", seed=1)
    absent = two_dof_case.fit(exact, "absent", outcome="training_diverged")
    case = two_dof_case.case(two_dof_case.fit(exact), wrong, absent)
    dims = ("role", "dof")
    shapes = variable(dims, np.array([two_dofs.START] * 2), "m", "release")
    release = xr.Dataset({"displacement": shapes}, {"role": ["train", "test"]})
    asked = case.scene["experiments"] | {"response": {}, "random_forcing": {"forcing": 0.05}}
    scene = {**case.scene, "experiments": asked}
    case = replace(case, scene=scene, full_order={"release": release})
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(FullOrder, "of_scene", lambda *given: two_dofs.full_order())
        return studies.study("trust", SETTINGS).job("models", case)


def test_an_exact_model_obeys_the_equations(made):
    exact = made.isel(fit=0)
    # Differences of fourth order over 0.003 of the time scale, less their rounding.
    assert (exact["error"] < 1e-4).all() and float(exact["release_error"]) < 1e-4
    assert float(exact["trusted_displacement"]) == float(exact["displacement"][-1]) > 0.0
    # It grows with the amplitude, and the motion of the release starts there.
    np.testing.assert_allclose(exact["displacement"] / exact["displacement"][0], [1.0, 2.0, 2.4])
    assert float(exact["release_displacement"]) >= np.abs(two_dofs.START).max() * (1 - 1e-9)


def test_the_error_of_a_wrong_stiffness_by_hand(made):
    """r = OFF w1^2 M q of the first mode, balanced in a vibration of the fastest oscillator."""
    wrong = made.isel(fit=1)
    expected = 100 * OFF * two_dofs.SQUARES[0] / two_dofs.SQUARES.sum()
    np.testing.assert_allclose(wrong["error"], expected, rtol=1e-5)
    assert expected > 100 * SETTINGS["tolerance"] and float(wrong["trusted_displacement"]) == 0.0


def test_the_balance_of_an_exact_model_and_of_a_wrong_one(made):
    """A motion of a wrong stiffness gains and loses up to OFF of its energy in springs; driven at
    resonance it has next to none in them when the signal is zero.
    """
    runs = ("decay", "forced", "response", "random_forcing")
    exact, wrong = (
        np.array([float(made.isel(fit=k)[f"{run}_balance"]) for run in runs]) for k in (0, 1)
    )
    # Under signals, the trapezoidal rule's (2 omega h)^2/12 of what the fastest motion loses.
    assert (exact < 1e-4).all() and (wrong > 1e-3).all() and (wrong < 3 * OFF).all()


def test_a_model_that_was_not_fitted_has_its_word(made):
    absent = made.isel(fit=2)
    assert str(absent["outcome"].values) == "training_diverged"
    assert np.isnan(absent["error"]).all() and np.isnan(absent["trusted_displacement"])
