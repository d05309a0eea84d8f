"""What threads share out is what one thread makes, to the last bit."""

import numpy as np
import pytest
from scenes import THESIS, body

from vibrom import effects
from vibrom.bodies import space
from vibrom.methods.equations import Equations
from vibrom.models.training import Training
from vibrom.solvers import threads


def test_items_keep_their_order_and_errors_arrive():
    for count in (1, 3):
        assert threads.mapped(lambda k: k * k, range(20), count) == [k * k for k in range(20)]
        with pytest.raises(ZeroDivisionError):
            threads.mapped(lambda k: 1 / (k - 3), range(5), count)


@pytest.mark.parametrize("text, count", [("3", 3), ("3,2", 3), (" 2 ", 2), ("", None), ("0", None)])
def test_the_number_of_threads_is_that_of_the_outermost_level(text, count, monkeypatch):
    monkeypatch.setattr("os.cpu_count", lambda: 7)
    monkeypatch.setenv("OMP_NUM_THREADS", text)
    assert threads.threads() == (count or 7)


def test_a_manifold_by_threads_is_that_by_one(monkeypatch):
    term, models = effects.assemble(space.build(body(cells=[12, 1])), THESIS), []
    for count, large in (("1", threads.LARGE), ("3", 1)):
        monkeypatch.setenv("OMP_NUM_THREADS", count)
        monkeypatch.setattr(threads, "LARGE", large)
        assert threads.worth(term.size) == int(count)
        models.append(Equations(order=5).learn(Training((), term=term)).to_dataset())
    one, other = models
    for name in one.variables:
        np.testing.assert_array_equal(one[name].values, other[name].values, err_msg=str(name))
