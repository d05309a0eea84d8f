"""What another scene of the run answered to the same question -> the artefacts of this one.

Two scenes with the same body are not asked twice what depends on nothing else: a response from
rest, a model made from the equations of motion.
"""

from typing import Any

from vibrom.artefacts.data import label, open_dataset, save_dataset
from vibrom.artefacts.identity import FITTED_ONCE, place

SAME = "same_"


def run(*, provenance: dict[str, str], **given: Any) -> None:
    """`given` holds, for each artefact, where that of the other scene lies, `same_<name>`, and
    where this one goes, `<name>`; all else in it is what made the other.
    """
    for key in (key for key in given if key.startswith(SAME)):
        path = given[key.removeprefix(SAME)]
        own = place(path)
        found = open_dataset(given[key], own["kind"])
        seed = None if own["seed"] == FITTED_ONCE else own["seed"]
        named = label(found, own["kind"], scene=own["scene"], method=own["method"], seed=seed)
        save_dataset(named, path, provenance)
