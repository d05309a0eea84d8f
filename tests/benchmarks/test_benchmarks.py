"""Rivals compute what we compute, and the page says what was measured; no time is asserted."""

import math
from importlib import import_module

import numpy as np
import pytest
from scenes import CANTILEVER, THESIS, body

from benchmarks import __main__ as command
from benchmarks import page
from benchmarks.rivals.scikit_fem_newmark import Beam
from benchmarks.table import Row, paired
from vibrom import effects
from vibrom.bodies import space
from vibrom.solvers.full.newmark import Newmark


@pytest.mark.parametrize("tricks", [False, True])
def test_the_full_order_rival_moves_as_we_do(tricks):
    made = space.build(body(cells=[6, 1]))
    term = effects.assemble(made, THESIS)
    start = 0.002 * (made.dof_location[:, 0] ** 2) * (made.dof_axis == 1)
    rival = Beam(made.basis, made.free, term.mass, term.damping, 104.0e9, 0.3, made.thickness)
    theirs = rival.run(start, 1e-5, 20, alpha=0.005, tolerance=1e-9, patience=3.0, tricks=tricks)
    ours = (
        Newmark(alpha=0.005, tolerance=1e-9)
        .run(term, start[:, None], np.array([1e-5]), 20, initial_acceleration="zero")
        .displacement[0]
    )
    # Each step is solved to 1e-9 of its forces; the motion covers a third of the start.
    assert np.abs(ours - theirs).max() <= 1e-6 * np.abs(theirs - start).max()


def test_better_is_more_than_one():
    assert Row("b", "time", 2.0, "s", "rival", 8.0).ratio == 4.0
    assert Row("b", "rate", 8.0, "1/s", "rival", 2.0, "higher").ratio == 4.0
    assert math.isnan(Row("b", "nothing to compare", 2.0, "s").ratio)


def test_rivals_take_turns():
    calls = []
    seconds = paired({"a": lambda: calls.append("a"), "b": lambda: calls.append("b")}, repeats=2)
    assert calls == ["a", "b"] * 3 and set(seconds) == {"a", "b"}


def test_every_benchmark_says_what_it_compares():
    for name in command.NAMES:
        module = import_module(f"benchmarks.{name}")
        title, paragraphs = page.words(module.__doc__)
        assert title and paragraphs and callable(module.measure)


def test_the_page_tells_the_command_and_the_machine(tmp_path, monkeypatch):
    monkeypatch.setattr(command, "RESULTS", tmp_path)
    monkeypatch.setattr(
        import_module("benchmarks.full_order"),
        "measure",
        lambda note: [Row("full_order", "steps & more", 3.0, "1/s", "a rival", 1.5, "higher")],
    )
    assert command.main(["full_order"]) == 0
    text = (tmp_path / "benchmarks.html").read_text()
    assert (
        "python -m benchmarks full_order" in text
        and "steps &amp; more" in text
        and "instruction set" in text
    )
    assert (tmp_path / "benchmarks.csv").read_text().splitlines() == [
        "benchmark,quantity,value,unit,rival,rival_value,ratio",
        "full_order,steps & more,3.0,1/s,a rival,1.5,2.0",
    ]


def test_an_unknown_benchmark_is_named(capsys):
    assert command.main(["sprint"]) == 2
    assert "'sprint' is unknown; choose from full_order" in capsys.readouterr().err


def test_the_cantilever_of_the_benchmarks_is_that_of_the_thesis():
    model = import_module("benchmarks.cantilever").build()
    assert model.space.size == 240 and model.frequency == pytest.approx(398.0325, abs=1e-3)
    assert space.build(CANTILEVER).size == model.space.size
