"""The cases of the grid, and what is said of decays."""

import numpy as np
import pytest
from oscillators import DAMPING, OMEGA, linear_rom
from vibrom.studies.grid import KINDS, SAMPLES, cases, let_go, rises, survive

from vibrom.models.rollout import Integrator

CHOSEN = cases([0.5, 1.0], np.linspace(0.7, 1.3, 5), 6, 1.3)


def test_cases_are_the_promised_ones_and_the_same_each_time():
    assert [int((CHOSEN.kind == kind).sum()) for kind in range(len(KINDS))] == [10, 6, 6]
    rest, released, pushed = (CHOSEN.kind == kind for kind in range(3))
    assert set(zip(CHOSEN.forcing[rest], CHOSEN.frequency[rest])) == {
        (a, w) for a in (0.5, 1.0) for w in np.linspace(0.7, 1.3, 5)
    }
    assert (
        (CHOSEN.radius[rest] == 0).all()
        and (CHOSEN.forcing[released] == 0).all()
        and (CHOSEN.forcing[pushed] == 1).all()
    )
    assert (CHOSEN.radius[~rest] > 0).all() and 1.0 < CHOSEN.radius.max() <= 1.3
    again = cases([0.5, 1.0], np.linspace(0.7, 1.3, 5), 6, 1.3)
    assert all(
        np.array_equal(getattr(CHOSEN, name), getattr(again, name))
        for name in ("radius", "draw", "frequency")
    )
    reach = np.array([2.0, 3.0, 10.0, 20.0])  # two oscillators
    start = CHOSEN.start(reach) / reach
    np.testing.assert_allclose(
        np.hypot(start[:, :2], start[:, 2:]), np.stack([CHOSEN.radius] * 2, axis=1), atol=1e-14
    )


def test_a_linear_oscillator_survives_and_its_energy_falls_as_it_must():
    rom, integrator = linear_rom(), Integrator(1e-9, 1e-11)
    outcome, failed_at, ratio = survive(
        rom, CHOSEN, np.ones(1), 0.01 * OMEGA**2, OMEGA, 20, integrator
    )
    assert (
        set(outcome) <= {"ok", "left_range"}
        and np.isfinite(failed_at[outcome == "left_range"]).all()
        and np.isnan(failed_at[outcome == "ok"]).all()
    )
    assert (ratio[CHOSEN.radius > 1.1] > 1.0).all()
    values, envelope = let_go(
        rom, CHOSEN, OMEGA, 12, integrator, lambda q, v: 0.5 * (v**2 + OMEGA**2 * q**2).sum(axis=1)
    )
    assert (
        values.shape == envelope.shape == (6, 12)
        and not rises(values).any()
        and not rises(envelope).any()
    )
    # Energy of a decay: e^(-c T) from one period to the next.
    np.testing.assert_allclose(
        values[:, 1:] / values[:, :-1], np.exp(-DAMPING * 2 * np.pi / OMEGA), rtol=1e-4
    )
    np.testing.assert_allclose(
        envelope[:, 0] / CHOSEN.radius[CHOSEN.kind == 1],
        1.0,
        atol=2 * np.pi * DAMPING / OMEGA + (np.pi / SAMPLES) ** 2 / 2,
    )


def test_runs_that_blow_up_say_when():
    fed = linear_rom()
    fed = type(fed)(
        **{name: getattr(fed, name) for name in fed.__dataclass_fields__}
        | {"dynamics": fed.dynamics * [[1.0, 1.0], [1.0, -10.0]]}
    )
    outcome, failed_at, _ = survive(fed, CHOSEN, np.ones(1), 1.0, OMEGA, 60, Integrator())
    released = CHOSEN.kind == 1
    assert (outcome[released] == "diverged").all()
    # It grows by e^(5 c t) to ten times the range; the last step may pass that by a tenth of a
    # period.
    expected = np.log(10 / CHOSEN.radius[released]) / (5 * DAMPING) * OMEGA / (2 * np.pi)
    np.testing.assert_allclose(failed_at[released], expected, atol=0.6)
    values, envelope = let_go(
        fed, CHOSEN, OMEGA, 40, Integrator(), lambda q, v: 0.5 * (v**2).sum(axis=1)
    )
    assert rises(values).all() and rises(envelope).all() and np.isnan(values[:, -1]).any()


@pytest.mark.parametrize(
    "values, rose",
    [
        ([4, 3, 2, 1], False),
        ([4, 3, 3.03, 1], False),
        ([4, 3, 3.2, 1], True),
        ([4, 3, np.nan, np.nan], True),
    ],
)
def test_rises(values, rose):
    assert rises(np.array([values], float))[0] == rose
