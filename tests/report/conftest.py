"""A small run by the real steps, some of its answers made to fail; and studies with numbers that
are chosen, so that tables of medians and counts can be checked by hand.
"""

import pytest
import studies
from small_run import FAILED, SmallRun, altered, failed

from vibrom.report.collection import Collection
from vibrom.report.scores import Scores


@pytest.fixture(scope="session")
def small(tmp_path_factory):
    """Two cases, three methods, two seeds; one training that diverges."""
    return SmallRun(tmp_path_factory.mktemp("run"))


@pytest.fixture(scope="session")
def real(small):
    """As it is."""
    return Collection.at(small.paths)


@pytest.fixture(scope="session")
def collection(real):
    """With failures, and with an ablation of the case small."""
    failures = {(*model, name): failed for model in FAILED for name in ("forced", "frc")}
    study = {("small", "full_order", None, "ablation"): lambda _: studies.ablation()}
    return altered(real, failures | study)


@pytest.fixture(scope="session")
def scores(collection):
    """Of its answers."""
    return Scores.of(collection)
