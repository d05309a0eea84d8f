"""A small run by the real steps, some of its answers made to fail; and studies with numbers that
are chosen, so that tables of medians and counts can be checked by hand.
"""

import pytest
import studies
import written
from small_run import FAILED, SmallRun, altered, failed

from vibrom.report.collection import Collection, Key
from vibrom.report.scores import Scores


@pytest.fixture(scope="session")
def small(tmp_path_factory):
    """Two cases, three methods, two seeds; one training that diverges. Nothing is timed again."""
    with pytest.MonkeyPatch.context() as once:
        once.setattr("vibrom.steps.ask.CALLS", 1)
        once.setattr("vibrom.steps.fit.FITS", 1)
        return SmallRun(tmp_path_factory.mktemp("run"))


@pytest.fixture(scope="session")
def real(small):
    """As it is."""
    return Collection.at(small.paths)


@pytest.fixture(scope="session")
def collection(real):
    """With failures, and of the studies an ablation of the case small alone."""
    own = ("ablation", "cost_full_order", "cost_reduced", "robustness")
    changes = dict.fromkeys(key for key in real.loaders if key.name in own)
    changes |= {(*model, name): failed for model in FAILED for name in ("forced", "frc")}
    changes[Key("small", "full_order", None, "ablation")] = lambda _: studies.ablation()
    return altered(real, changes)


@pytest.fixture(scope="session")
def scores(collection):
    """Of its answers."""
    return Scores.of(collection)


@pytest.fixture(scope="session")
def made(small, tmp_path_factory):
    """Tables, figures, scores, the page twice, the store and the headline, by their steps."""
    folder = tmp_path_factory.mktemp("out")
    written.write(small, folder)
    return folder


@pytest.fixture(scope="session")
def page(made):
    """The text of the report."""
    return (made / "report.html").read_text(encoding="utf-8")
