"""The study of the methods where a value that it tries does not go with the scene's settings."""

import numpy as np
import pytest
import xarray as xr
from vibrom.steps.cost_reduced import ERRORS, Row, Study, as_dataset

from vibrom.models.rollout import Integrator


@pytest.fixture
def study():
    """Two oscillators that decay, and an SSMLearn of two modes."""
    t, omega, c = np.linspace(0, 10, 1001), np.array([3.0, 7.0]), 0.05
    s = -c + 1j * omega
    motion = {
        name: (("time", "dof"), (s**power * np.exp(np.outer(t, s))).real)
        for power, name in enumerate(("displacement", "velocity", "acceleration"))
    }
    train = xr.Dataset({**motion, "outcome": "ok", "seconds": 1.0, "period": 2.0}, {"time": t})
    operators = {"mass": np.ones(2), "damping": np.full(2, 2 * c), "stiffness": omega**2 + c**2}
    structure = xr.Dataset(
        {
            "mode_shape": (("mode", "dof"), np.eye(2)),
            "frequency": ("mode", np.sqrt(operators["stiffness"])),
            **{
                f"{name}_{part}": (f"{name}_entry", values)
                for name, value in operators.items()
                for part, values in (("row", [0, 1]), ("column", [0, 1]), ("value", value))
            },
        },
        attrs={"body": "{}", "effects": "{}"},
    )
    method = {"kind": "ssmlearn", "settings": {"modes": 2}, "seeded": False, "start": None}
    return Study(
        {"structure": structure, "train": train, "test": train, "forced": train, "frc": train},
        {"ssmlearn_2": method},
        None,
        "cpu",
        Integrator(),
        1,
        0.0,
    )


@pytest.mark.parametrize(
    "changes, cure",
    [
        ({"dissipative": 5}, "set dissipative: 0"),
        ({"modes": 3}, "choose 1 to 2"),
        ({"extrapolation": "flat"}, "give none or linear"),
    ],
)
def test_a_setting_that_does_not_go_with_the_others_is_skipped(study, capsys, changes, cure):
    row = study.varied("ssmlearn_2", changes)
    assert {answer[3] for answer in row.answers.values()} == {"skipped"} and set(
        row.answers
    ) == set(ERRORS)
    assert cure in capsys.readouterr().err
    fitted = study.fit("ssmlearn_2", {"order_dynamics": 2})
    assert (
        fitted.outcome == "ok"
        and as_dataset([row, Row("ssmlearn_2", None, "", "", fitted, row.answers)]).sizes["setting"]
        == 2
    )
