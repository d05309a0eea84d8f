"""Motions that go to a scratch file, against the same in memory."""

import os
import tracemalloc
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest
import two_dofs
import xarray as xr
from scipy.sparse import diags, identity

from vibrom.artefacts.data import label, open_dataset, save_dataset
from vibrom.artefacts.hardware import TooLarge
from vibrom.experiments.forced import Forced
from vibrom.experiments.response import Response
from vibrom.models import balance, samples, scratch
from vibrom.models.model import Drive, Watch
from vibrom.term import Term

RNG = np.random.default_rng(7)
Q = RNG.standard_normal((2, 30, 4))  # runs, steps, displacements
SLICES = {
    "a run": np.s_[1],
    "a row": np.s_[0, 7],
    "the last rows": np.s_[:, 20:],
    "every third": np.s_[1, ::3],
    "rows in a list": np.s_[:, [4, 9, 28]],
    "columns": np.s_[:, :, [3, 1]],
    "a column": np.s_[1, :, -1],
    "none": np.s_[0, 5:5],
    "all": np.s_[:, :, :],
}


@pytest.mark.parametrize("part", SLICES.values(), ids=SLICES)
def test_a_slice_of_the_file_is_that_of_the_array(part, monkeypatch):
    monkeypatch.setattr(samples, "BLOCK", 8 * 4 * 3)  # three rows
    rest = RNG.standard_normal(4)
    made = scratch.room(2, 30, 4, rest)
    for first in (0, 11):  # as a time loop shows them: some steps of some runs
        steps = np.arange(first, 11 if first == 0 else 30)
        shown = (Q + rest)[:, steps].transpose(1, 2, 0)
        made.see(steps, slice(0, 2), shown, 0.0 * shown, 0.0 * shown)
    lazy = made.variable
    assert not lazy._in_memory
    # (q + q_0) - q_0 is q but for the rounding of the sum.
    read, whole = [], os.pread
    monkeypatch.setattr(os, "pread", lambda *given: read.append(given[1] // 8) or whole(*given))
    np.testing.assert_allclose(lazy[part].values, Q[part], rtol=1e-13, atol=1e-14)
    assert all(count <= 4 * 3 for count in read)  # however far apart its rows are


def test_threads_may_read_the_same_file():
    made = scratch.OnScratch((1, 1000, 500), 0.0)
    rows = np.arange(1000.0)[:, None] + np.zeros(500)
    made.append(0, rows)
    with ThreadPoolExecutor(4) as pool:
        found = list(pool.map(lambda row: made.variable[0, row].values, [*range(0, 1000, 7)] * 3))
    np.testing.assert_array_equal(found, [*rows[::7]] * 3)


def test_small_motions_are_in_memory_and_too_large_ones_are_refused_in_a_line(monkeypatch):
    assert scratch.room(1, 101, 4) is None
    with pytest.raises(TooLarge, match="scratch file.*TMPDIR"):
        scratch.room(1, 10**9, 10**6)


@pytest.mark.parametrize("runs", [1, 3])
def test_the_full_order_answers_alike_from_a_file(runs, monkeypatch):
    model = two_dofs.full_order()
    drive = Drive(np.linspace(0.1, 0.2, runs), model.frequency * np.linspace(0.9, 1.1, runs))
    instants = drive.period[:, None] * np.arange(20, 51) / 50
    watches = Watch(instants), Watch(instants[:, ::5]), Watch(instants, model.probes)
    start = np.zeros((runs, 4))
    whole = model.motion(start, drive, *watches).displacement
    monkeypatch.setattr(samples, "BLOCK", 100)
    found = model.motion(start, drive, *watches).displacement
    assert [isinstance(one, xr.Variable) for one in found] == [True, True, False]
    for one, other in zip(found, whole):
        np.testing.assert_array_equal(np.asarray(one), other)


@pytest.mark.parametrize("question", [Response(periods=3), Forced(0.1, periods=4)])
@pytest.mark.parametrize("kind", ["full_order", "reduced"])
def test_answers_in_blocks_are_those_in_memory(question, kind, tmp_path, monkeypatch):
    """Their files, too, but for the wall time."""
    model, given = getattr(two_dofs, kind)(), two_dofs.given()
    truth, found = question.ask(two_dofs.full_order(), given), []
    for name in ("whole", "blocks"):
        answer = question.ask(model, given)
        # A row at a time may add up in another order.
        scores = question.score(answer, truth)
        answer = answer.assign(seconds=answer["seconds"].copy(data=1.0), score_value=0.0)
        answer["score_value"].attrs |= {"units": "1", "long_name": "none"}
        answer = label(answer, "forced", scene="two", method=kind)
        save_dataset(answer, tmp_path / f"{name}.nc")
        kept = question.stored(answer, truth).load()
        found.append((open_dataset(tmp_path / f"{name}.nc", "forced"), scores, kept))
        for size_of in ("models.samples.BLOCK", "artefacts.on_disk.LARGE"):
            monkeypatch.setattr(f"vibrom.{size_of}", 500)
    (whole, scores, kept), (blocks, others, kept_blocks) = found
    assert list(others.values()) == pytest.approx(list(scores.values()), rel=1e-9, abs=1e-9)
    xr.testing.assert_allclose(blocks, whole, rtol=1e-12, atol=1e-14)
    xr.testing.assert_allclose(kept_blocks, kept, rtol=1e-9, atol=1e-12)
    if kind == "full_order":
        assert blocks.attrs["content"] == whole.attrs["content"]


def test_the_work_balance_in_blocks_is_that_of_the_whole(monkeypatch):
    model = two_dofs.full_order()
    drive = Drive(np.array([0.1]), np.array([model.frequency]))
    instants = model.period * np.arange(4 * 50 + 1) / 50
    motion = model.motion(np.zeros((1, 4)), drive, Watch(instants)).displacement[0][0]
    asked = model.term, model.rest, model.period, drive, motion, 50
    whole = balance.of_motion(*asked)
    monkeypatch.setattr(balance, "BLOCK", 8 * 2 * 11)
    assert balance.of_motion(*asked) == pytest.approx(whole, rel=1e-9)


def test_the_full_order_holds_no_motion(tmp_path, monkeypatch):
    """A chain of 400 masses, 5 periods of 400 steps: 6.4 MB, of which three arrays were held."""
    n = 400
    chain = diags([[-1.0] * (n - 1), [2.0] * n, [-1.0] * (n - 1)], [-1, 0, 1], format="csr")
    body = Term(mass=identity(n, format="csr"), stiffness=chain, load=np.eye(n)[0])
    known, zeros = two_dofs.full_order(), np.zeros(n)
    model = replace(known, term=body, rest=zeros, frequency=0.5)
    monkeypatch.setattr("vibrom.solvers.full.linear.chunk", lambda n, width: 50)
    monkeypatch.setattr(samples, "BLOCK", 2**17)
    drive = Drive(np.array([1.0]), np.array([0.5]))
    watch = Watch(model.period * np.arange(5 * 400 + 1) / 400)

    def peak(periods: int) -> int:
        part = replace(watch, instants=watch.instants[: periods * 400 + 1])
        tracemalloc.start()
        motion = model.motion(np.zeros((1, 2 * n)), drive, part).displacement[0][0]
        held = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        assert np.abs(motion[-1].values).max() > 0.0
        return held

    peak(1)  # loads and compiles
    assert peak(5) < 2.0e6
