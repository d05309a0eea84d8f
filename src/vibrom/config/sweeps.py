"""What the study of costs varies: settings of a method, of its start, or of the study itself."""

from typing import Any

from vibrom.config import plugs
from vibrom.config.check import checked
from vibrom.config.errors import closest
from vibrom.config.kinds import Count, Positive
from vibrom.config.layers import Layers
from vibrom.config.method_file import MethodFile

# Of the training data, and of the integration of the fitted model.
OWN = {"thin": Count, "periods": Count, "rtol": Positive}


def check_sweeps(
    reduced: dict[str, list], methods: dict[str, MethodFile], path: tuple, layers: Layers
) -> dict[str, list]:
    """The sweeps of each method that runs, with values of the kind of what they vary."""
    made = {}
    for name in methods:
        made[name] = [
            {**sweep, "over": _over(name, sweep, methods, (*path, name, place), layers)}
            for place, sweep in enumerate(reduced.get(name, []))
        ]
    return {name: made.get(name, sweeps) for name, sweeps in reduced.items()}


def _over(
    name: str, sweep: dict[str, Any], methods: dict[str, MethodFile], path: tuple, layers: Layers
) -> list[Any]:
    values = sweep["over"]
    for key in sweep["vary"]:
        start = methods[name].starts_from or name
        of_start = start != name and key.startswith("start.")
        which = start if of_start else name
        setting, known = key.removeprefix("start.") if of_start else key, _known(methods[which])
        known |= {} if of_start else {"rtol": OWN["rtol"]} if methods[which].rule else OWN
        if setting not in known:
            cure = f"is no setting of {which}; {closest(setting, known)}"
            layers.refuse((*path, "vary"), key, cure)
        values = [
            checked(value, known[setting], (*path, "over", place), layers.refuse)
            for place, value in enumerate(values)
        ]
    return values


def _known(method: MethodFile) -> dict[str, Any]:
    """Setting -> its kind; nothing is known of those of an outside method."""
    if method.rule:
        return {}
    return plugs.kinds_of(plugs.settings_of("methods", str(method.method)))
