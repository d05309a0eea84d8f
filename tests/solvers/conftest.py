"""The thesis's cantilever, for all tests of solvers."""

import pytest
from scenes import CANTILEVER, THESIS

from vibrom import effects
from vibrom.bodies import space


@pytest.fixture(scope="session")
def cantilever():
    made = space.build(CANTILEVER)
    return made, effects.assemble(made, THESIS)
