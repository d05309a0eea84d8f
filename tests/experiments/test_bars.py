"""Long answers tell how far they are while they are made."""

import re

import pytest
from two_dofs import given, reduced

from vibrom.artefacts import progress
from vibrom.experiments import experiment

LINE = re.compile(r"two: one: .+: +(\d+) %, [\d.,]+ (motions|periods)/s, \d+ s left")
LONG = {
    "branches": {"forcing": 1e-3, "resonances": 4, "sweeps": 2, "periods": 1},
    "s_curve": {"frequency": 1.05, "forcing": 1e-3},
    "resonance": {"forcing": 1e-3},
    "sweeps": {"forcing": 1e-3, "periods": 2, "longest": 2, "settle": 3, "frequencies": 5},
}


@pytest.mark.parametrize("name", LONG)
def test_an_answer_tells_how_far_it_is(name, monkeypatch, capsys):
    monkeypatch.setattr(progress, "LINE_EVERY", 0.0)
    experiment(name, LONG[name]).ask(reduced(), given(title="two: one: "))
    lines = [LINE.fullmatch(line) for line in capsys.readouterr().err.splitlines()]
    told = [int(line[1]) for line in lines if line]
    assert len(told) > 2 and told == sorted(told) and told[-1] <= 100
    if name == "sweeps":  # whose periods are known beforehand
        assert told[-1] == 100
