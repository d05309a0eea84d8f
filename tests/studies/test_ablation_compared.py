"""Decays with and without an effect: about other rest states, after a failure, and on disk."""

from dataclasses import replace

import numpy as np
import pytest
from ablated import DAMPING, LINEAR, STEPS, TIP, ask, bent, outcomes
from scenes import body

from vibrom import effects
from vibrom.bodies import space
from vibrom.models import full_order, samples
from vibrom.solvers.full.modes import eigenmodes
from vibrom.solvers.full.newmark import Newmark
from vibrom.solvers.full.static import equilibrium


def test_without_gravity_the_body_starts_in_the_same_place_and_swings_about_another(tmp_path):
    shape, listed = body(cells=[10, 1], height=0.1), {**LINEAR, "gravity": {}, "point_load": TIP}
    answers, made = ask(tmp_path, shape, listed, bent(1e-4), decay_periods=3, forced_periods=1)
    less, whole = answers.sel(left_out="gravity"), answers.sel(left_out="nothing")
    assert float(less["decay_displacement"][0]) == pytest.approx(
        float(whole["decay_displacement"][0]), rel=1e-12
    )
    # Both are linear: their distance d starts from zero under M d'' + K d = -p_0, the free
    # vibration of the sag about itself.
    term = effects.assemble(space.build({**shape, "probes": {}}), LINEAR)
    loaded_term = effects.assemble(space.build({**shape, "probes": {}}), {**LINEAR, "gravity": {}})
    sag, (omega,), steps = equilibrium(loaded_term), eigenmodes(term, 1)[0], 3 * STEPS
    swinging = (
        Newmark(tolerance=1e-8)
        .run(term, sag[:, None], np.array([2 * np.pi / omega / STEPS]), steps)
        .displacement[0, ::4]
        - sag
    )
    size = (
        1e-4
        * np.linalg.norm(made["mode_shape"].values[0])
        / abs(made["mode_shape"].values[0, int(made["probe_dof"].values[0])])
    )
    # The largest norm of a swing from rest is that of its start, up to what the time step misses of
    # it.
    assert float(less["decay_nmte"]) == pytest.approx(
        100 * np.linalg.norm(swinging, axis=1).mean() / size, rel=1e-3
    )
    assert (
        outcomes(answers)["elasticity"] == "no_equilibrium" and outcomes(answers)["gravity"] == "ok"
    )


def test_a_step_that_does_not_converge_is_an_outcome_of_the_body_that_took_it(
    tmp_path, monkeypatch
):
    """One iteration is not enough of coarse steps; a linear body takes none."""
    monkeypatch.setattr(
        full_order, "Newmark", lambda *given: replace(Newmark(*given), max_iterations=1)
    )
    answers, _ = ask(
        tmp_path,
        body(cells=[20, 1]),
        {**LINEAR, "geometric_nonlinearity": {}, "point_load": TIP},
        bent(0.1),
        steps_per_period=20,
        decay_periods=2,
        forced_periods=1,
    )
    found = outcomes(answers)
    assert found["nothing"] == "no_convergence" and found["geometric_nonlinearity"] == "ok"
    assert float(answers["failed_at"].sel(left_out="nothing")) > 0.0
    linear = answers.sel(left_out="geometric_nonlinearity")
    assert (
        np.isnan(linear["decay_nmte"])
        and np.isnan(linear["seconds_ratio"])
        and float(linear["seconds_per_step"]) > 0.0
    )


def test_decays_on_a_scratch_file_have_the_errors_of_those_in_memory(tmp_path, monkeypatch):
    """A beam under its weight, so that rest states differ; rounding is all that may."""
    listed = {**LINEAR, **DAMPING, "gravity": {}}
    found = []
    for block in (samples.BLOCK, 1000):
        monkeypatch.setattr(samples, "BLOCK", block)
        lengths = {"decay_periods": 2, "forced_periods": 1}
        answers, *_ = ask(tmp_path, body(cells=[6, 1]), listed, lambda mode, tip: mode, **lengths)
        found.append(answers["decay_nmte"].values)
    one, other = found
    assert np.nanmax(one) > 1.0
    np.testing.assert_allclose(other, one, rtol=1e-9, atol=1e-9)
