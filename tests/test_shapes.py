"""Shapes that comments name are checked while the tests run."""

import importlib

import numpy as np
import pytest
import shapes
from jaxtyping import TypeCheckError

from vibrom.models.model import Drive, Watch


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("(b, m, r)", "b m r"),
        ("(b,)", "b"),
        ("(*batch, 2n)", "*batch n_times_2"),
        ("(steps + 1, states)", "_ states"),
        ("(a word, another)", None),
        ("(see below)", None),
    ],
)
def test_words_become_shapes(text, found):
    assert shapes.shape_of(text) == found


def test_a_shape_that_is_not_the_one_of_the_comment_is_refused():
    Drive(np.ones(3), np.ones(3))
    with pytest.raises(TypeCheckError):
        Drive(np.ones(3), np.ones(2))
    with pytest.raises(TypeCheckError):
        Drive(np.ones((3, 1)), np.ones(3))
    Watch(np.ones(4))
    Watch(np.ones((2, 4)), np.arange(3))  # one of two
    with pytest.raises(TypeCheckError):
        Watch(np.ones((2, 4, 1)))


def test_many_places_are_checked():
    for name in ("models.full_order", "models.reduced", "solvers.periodic.response"):
        importlib.import_module(f"vibrom.{name}")
    importlib.import_module("vibrom.methods.split")
    assert shapes.count > 20
