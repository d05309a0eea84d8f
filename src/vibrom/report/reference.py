"""A run's scores beside those of the project's own run.

    |value - reference| <= share |reference| + least

What draws no random numbers differs between machines by rounding alone, which the error of a motion
magnifies; a training ends in another minimum nearby, and how many points of its curves end how may
change with it. Wall times are not compared.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import pandas as pd

from vibrom.artefacts.files import DataError, write
from vibrom.config.places import UNSEEDED

KEY = ["scene", "method", "seed", "experiment", "metric", "unit"]
FIXED = {"percent": (0.02, 1e-3)}  # unit -> share, least: 2 %, or 0.001 percentage points
TRAINED = {"percent": (0.5, 0.02), "1": (0.5, 1.0)}
OTHERS = 1e-3, 0.0  # frequencies and the like, and what is counted


MISSING, NEW = "is missing", "is new"


class Difference(NamedTuple):
    """One score that is not the reference's."""

    name: str
    words: str

    def __str__(self) -> str:
        return f"{self.name}: {self.words}"


def read(path: str | Path) -> pd.DataFrame:
    """The scores of a run but for wall times; raises DataError where there are none."""
    try:
        table = pd.read_csv(path, keep_default_na=False, na_values={"value": [""]})
        table = table.astype({"seed": str})
        return table[table["unit"] != "s"].set_index(KEY)[["value", "outcome"]]
    except OSError as error:
        raise DataError(
            f"{path}: cannot be read ({error.strerror}); run `snakemake scores`"
        ) from error
    except (KeyError, ValueError) as error:
        raise DataError(f"{path}: is no table of scores ({error}); give a scores.csv") from error


def tolerance(seed: str, unit: str) -> tuple[float, float]:
    """(share, least) of a score."""
    return (FIXED if seed == UNSEEDED else TRAINED).get(unit, OTHERS)


def differences(fresh: pd.DataFrame, reference: pd.DataFrame) -> Iterator[Difference]:
    """What differs by more than its tolerance, is missing or is new."""
    for key, wanted in reference.iterrows():
        scene, method, seed, experiment, metric, unit = key
        name = f"{scene}, {method}, {seed}: {experiment} {metric}"
        if key not in fresh.index:
            yield Difference(name, MISSING)
            continue
        found = fresh.loc[key]
        if seed == UNSEEDED and found["outcome"] != wanted["outcome"]:
            yield Difference(name, f"ended {found['outcome']}, the reference {wanted['outcome']}")
            continue
        one, other = float(found["value"]), float(wanted["value"])
        share, least = tolerance(seed, unit)
        # Not a number on both sides is the same.
        if abs(one - other) > share * abs(other) + least or (one == one) != (other == other):
            allowed = f"{share:.1%} + {least:g}" if least else f"{share:.1%}"
            yield Difference(name, f"{one:.6g}, the reference {other:.6g} {unit} ({allowed})")
    for key in fresh.index.difference(reference.index):
        yield Difference(f"{key[0]}, {key[1]}, {key[2]}: {key[3]} {key[4]}", NEW)


def keep(fresh: str | Path, reference: str | Path) -> str:
    """Makes a run's scores the reference."""
    table = read(fresh).reset_index()[[*KEY[:5], "value", "unit", "outcome"]]
    write(reference, table.to_csv(index=False, float_format="%.7g"))
    return f"{reference} has the {len(table)} scores of {fresh} now."


def compared(fresh: str | Path, reference: str | Path) -> tuple[str, bool]:
    """What to print, and whether all is as it should be."""
    run, known = read(fresh), read(reference)
    found = list(differences(run, known))
    missing, new = (sum(one.words == words for one in found) for words in (MISSING, NEW))
    differ = len(found) - missing - new
    head = f"{len(known) - differ - missing} of {len(known)} scores of {reference} are reproduced"
    if found:
        head += f"; {differ} differ, {missing} are missing, {new} are new, of those of {fresh}"
    return "\n".join([f"{head}.", *map(str, found)]), not found
