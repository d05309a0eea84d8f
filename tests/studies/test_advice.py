"""Which sets of effects may be left out, from errors that are known."""

import numpy as np
import pytest
import xarray as xr

from vibrom.studies.parts.advice import advise, error, line, variables

WHOLE = {"outcome": "ok", "decay_nmte": 0.0, "forced_amplitude": np.array([0.5, 2.0])}


def record(percent, outcome="ok"):
    return WHOLE | {"outcome": outcome, "decay_nmte": abs(percent)}


def advised(worth, tolerance=0.05, **endings):
    """Errors that add up, with their signs; and the sets that were evaluated."""
    asked = []

    def evaluate(names):
        asked.append(names)
        return record(sum(worth[name] for name in names))

    single = {name: record(value) for name, value in worth.items()}
    single |= {name: record(0.0, ending) for name, ending in endings.items()}
    return advise(single, WHOLE, tolerance, evaluate), asked


def test_errors_that_add_up_leave_the_smaller_set():
    advice, asked = advised({"a": 3.0, "b": 4.0, "c": 1.5})
    assert set(advice.left_out) == {"a", "c"} and advice.error == pytest.approx(4.5)
    assert advice.tried == 7 and len(asked) == 4


def test_errors_that_cancel_are_found_though_neither_effect_may_go_alone():
    advice, _ = advised({"a": 20.0, "b": -19.0})
    assert set(advice.left_out) == {"a", "b"} and advice.error == pytest.approx(1.0)


def test_what_ends_otherwise_stays():
    advice, asked = advised({"a": 1.0}, load="unforced", mass="needed")
    assert advice.left_out == ("a",) and not asked
    nothing, _ = advised({"a": 7.0}, load="unforced")
    assert nothing.left_out == () and nothing.error == 0.0


def test_of_many_effects_few_sets_are_tried():
    worth = dict(zip("abcdefgh", (8.0, 0.1, 4.0, 2.0, 2.5, 30.0, 0.2, 9.0)))
    advice, asked = advised(worth)
    assert set(advice.left_out) == {"b", "g", "d", "e"} and advice.error == pytest.approx(4.8)
    assert len(asked) <= 8


def test_the_error_is_the_larger_one_of_decay_and_amplitudes():
    other = WHOLE | {"decay_nmte": 3.0, "forced_amplitude": np.array([0.5, 2.2])}
    assert error(other, WHOLE) == pytest.approx(10.0)
    assert error(other | {"forced_amplitude": np.array([0.5, 2.0])}, WHOLE) == pytest.approx(3.0)
    assert error(other | {"decay_nmte": np.nan}, WHOLE) == np.inf
    at_rest = WHOLE | {"forced_amplitude": np.zeros(2)}
    assert error(at_rest | {"decay_nmte": 1.0}, at_rest) == pytest.approx(1.0)


def test_it_is_said_in_a_line():
    advice, _ = advised({"a_b": 2.46, "c": 9.0})
    study = xr.Dataset(variables(advice, 5.123), attrs={"tolerance": 0.05})
    assert line(study, "small", ["mass", "a_b", "c"]) == (
        "within 5 % small needs mass, c: without a b it is off by 2.5 %, and a step is 5.1 times "
        "as fast"
    )
    study["advised"] = study["advised"].copy(data="")
    assert line(study, "small", ["mass"]) == "within 5 % small needs all of its effects"
