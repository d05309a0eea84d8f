"""The dataset kinds: what crosses from one rule to the next.

Every artefact is one netCDF file that opens as one `xarray.Dataset`. It names its kind, its scene
and its model, carries units and long names on all variables (CF conventions), and says which code
and which packages made it. `save_dataset` refuses what breaks that promise and writes all or
nothing; `open_dataset` refuses a file that is torn, damaged, foreign, or another artefact than the
one that belongs there, in one line that names the cure.
"""

import json
from pathlib import Path

import numpy as np
import xarray as xr

from vibrom.artefacts import identity, on_disk
from vibrom.artefacts.files import DataError, replacing
from vibrom.artefacts.identity import FITTED_ONCE

CONVENTIONS = "CF-1.11"

# kind -> variables that a file of that kind always has. Of an experiment that is what makes it one:
# an outcome and scores.
KINDS: dict[str, frozenset[str]] = {
    "structure": frozenset({"mode_shape", "frequency", "damping_ratio", "load", "probe_dof"}),
    "release": frozenset({"displacement"}),
    "trajectory": frozenset(
        {"displacement", "velocity", "acceleration", "probe_displacement", "outcome", "failed_at"}
    ),
    "ablation": frozenset({"first_frequency", "decay_nmte", "seconds_per_step", "outcome"}),
    "cost_full_order": frozenset({"study", "error", "seconds", "outcome", "reference_error"}),
    "cost_reduced": frozenset({"varied", "error", "seconds", "outcome", "mapping_seconds"}),
    "robustness": frozenset({"outcome", "failed_at"}),
    "trust": frozenset({"model", "error", "outcome"}),
    "rom": frozenset({"outcome"}),
    "losses": frozenset({"train_total"}),
}
ANSWER = frozenset({"outcome", "failed_at", "seconds", "score_value"})
STUDY = frozenset[str]()  # of an artefact that names the study that made it


def variable(dims, values, units: str, long_name: str, **attributes) -> xr.Variable:
    """One array with its units and long name."""
    return xr.Variable(dims, values, {"units": units, "long_name": long_name, **attributes})


def label(
    dataset: xr.Dataset,
    kind: str,
    *,
    scene: str,
    method: str,
    seed: int | None = None,
    **attributes,
) -> xr.Dataset:
    """`dataset` with the attributes that say what it is; seed None is a model that was fitted
    without one.
    """
    return dataset.assign_attrs(
        kind=kind,
        scene=scene,
        method=method,
        seed=FITTED_ONCE if seed is None else int(seed),
        Conventions=CONVENTIONS,
        title=f"vibrom {kind}: {method} in scene {scene}",
        **{
            key: value if isinstance(value, (str, int, float)) else json.dumps(value)
            for key, value in attributes.items()
        },
    )


def check(dataset: xr.Dataset, kind: str, where: str) -> None:
    """Raise `DataError` unless `dataset` is a complete artefact of this kind."""
    found = dataset.attrs.get("kind")
    if found != kind:
        raise DataError(
            f"{where}: kind is {found!r}, but {kind!r} is needed here; give a file made by the "
            "matching rule"
        )
    needed = KINDS.get(kind, STUDY if "study" in dataset.attrs else ANSWER)
    missing = sorted(needed - set(dataset.variables))
    if missing:
        raise DataError(
            f"{where}: the {kind} lacks {', '.join(missing)}; delete the file and run again"
        )
    bare = sorted(
        str(name)
        for name, array in dataset.variables.items()
        if not {"units", "long_name"} <= set(array.attrs)
    )
    if bare:
        raise DataError(
            f"{where}: no units or long_name on {', '.join(bare)}; give both to every variable"
        )


def save_dataset(
    dataset: xr.Dataset, path: str | Path, provenance: dict[str, str] | None = None
) -> None:
    """Write all of `dataset` to `path`, or leave `path` as it was."""
    dataset = dataset.assign_attrs(provenance or {})
    check(dataset, str(dataset.attrs.get("kind")), str(path))
    dataset = dataset.assign_attrs(content=identity.content(dataset))
    # Coordinates have no gaps (CF), and a fill value on them confuses other readers; integers need
    # none either.
    encoding = {
        name: {"_FillValue": None}
        for name, array in dataset.variables.items()
        if name in dataset.coords or array.dtype.kind in "iu"
    }
    large = on_disk.large(dataset)
    with replacing(path, dataset.nbytes) as partial:
        rest = dataset.drop_vars(large)
        rest.to_netcdf(
            partial,
            engine="netcdf4",
            encoding={name: how for name, how in encoding.items() if name in rest.variables},
        )
        on_disk.add(partial, {name: dataset.variables[name] for name in large})


def open_dataset(
    path: str | Path, kind: str, *, lazy: bool = False, large: int | None = None
) -> xr.Dataset:
    """The dataset of this kind at `path`: in memory, or `lazy`, with large variables on disk until
    something is read of them; those of more bytes than `large` are let go once they are checked.
    """
    if not Path(path).exists():
        raise DataError(f"{path}: no such file; run the rule that makes this {kind}")
    try:
        with xr.open_dataset(path, engine="netcdf4", cache=False) as opened:
            dataset = on_disk.left(opened, path) if lazy else opened.load()
    except (OSError, ValueError, RuntimeError) as error:
        raise identity.unreadable(path, error) from error
    identity.check_version(path, dataset.attrs)
    check(dataset, kind, str(path))
    identity.check_place(path, dataset.attrs)
    identity.check_content(path, dataset)
    return dataset if large is None else on_disk.let_go(dataset, path, large)


def scored(dataset: xr.Dataset, values: dict[str, float], units: dict[str, str]) -> xr.Dataset:
    """`dataset` with its scores, each in its unit; one without a value is NaN."""
    return dataset.assign(
        score_value=variable(
            "score",
            np.array([values.get(name, np.nan) for name in units], float),
            "1",
            "score, in the unit of score_unit",
        ),
    ).assign_coords(
        score=variable("score", np.array(list(units), dtype=object), "1", "name of the score"),
        score_unit=variable(
            "score", np.array(list(units.values()), dtype=object), "1", "unit of the score"
        ),
    )


def outcome_variables(
    outcome: str, failed_at: float = np.nan, seconds: float = np.nan
) -> dict[str, xr.Variable]:
    """How a run ended, when it failed [s of simulated time], and what it took [s of wall time]."""
    return {
        "outcome": variable((), outcome, "1", "how the run ended"),
        "failed_at": variable(
            (),
            float(failed_at),
            "s",
            "simulated time at which the run failed or first left the training range",
        ),
        "seconds": variable(
            (),
            float(seconds),
            "s",
            "wall time of the computation, loading and compilation excluded",
        ),
    }
