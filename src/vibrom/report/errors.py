"""Errors of the models in one experiment, beside the thesis's: what three tables share."""

import numpy as np
import xarray as xr

from vibrom.artefacts.outcome import Outcome
from vibrom.report.collection import FULL_ORDER, Collection, outcome, scalar
from vibrom.report.columns import Column, Row, as_given, hidden, over_seeds
from vibrom.report.scores import NO_SPREAD, Scores, Spread, endings
from vibrom.thesis import published as thesis

ZERO = Spread(0.0, 0.0, 0.0)


def _error(row: Row) -> str:
    if row["method"] == FULL_ORDER and row["nmte_percent"] == 0.0:
        return "reference"
    return over_seeds(Spread(*(row[name] for name in NMTE.names)))


NMTE = Column("nmte_percent", "NMTE [%]", spread=True, text=_error)
THESIS = (
    Column(
        "thesis_percent",
        "Thesis NMTE [%]",
        text=lambda row: row["thesis_outcome"] or as_given(row["thesis_percent"]),
    ),
    *hidden("thesis_outcome"),
)
CONVERGED = Column("converged_nmte_percent", "NMTE, converged [%]", spread=True)
AMPLITUDE = Column("amplitude_error_percent", "Amplitude error [%]", spread=True)
CHANGE = Column("change", optional=True)  # of a forced run in its last quarter, largest over seeds
TIMES = (
    Column("failed_at_s", "First failure [s]"),
    Column("left_range_at_s", "Left range [s]"),
)


def rows(
    experiment: str,
    reference: str,
    columns: tuple[Column, ...],
    collection: Collection,
    scores: Scores,
) -> list[dict[str, object]]:
    """These columns of a row a case and model. The full order is the reference: its error is zero
    where its own run, called `reference` in the collection, ended well.
    """
    names, made = [name for column in columns for name in column.names], []
    for scene, model in collection.models:
        row = {"case": scene, "method": model, "seeds": len(collection.seeds(scene, model))}
        if model == FULL_ORDER:
            run = collection.find(scene, FULL_ORDER, reference)
            zero = ZERO if outcome(run).has_value else NO_SPREAD
            row |= zero.columns("nmte_percent") | zero.columns("amplitude_error_percent")
            own = float(scalar(run, "converged_nmte"))
            row |= Spread(own, own, own).columns("converged_nmte_percent")
            row |= {"thesis_outcome": "", "outcome": outcome(run)}
            row |= first_times([run])
        else:
            error, converged = (
                scores.spread(scene, model, experiment, f"{against}nmte_percent")
                for against in ("", "converged_")
            )
            row |= converged.columns("converged_nmte_percent")
            # It has a sign, and so no worst side.
            amplitude = scores.spread(
                scene, model, experiment, "amplitude_error_percent", worst=False
            )
            row |= error.columns("nmte_percent") | amplitude.columns("amplitude_error_percent")
            published, verdict = thesis.percent(experiment, scene, model)
            row |= {"thesis_percent": published, "thesis_outcome": verdict}
            row |= {"outcome": endings(collection, scores, scene, model, experiment)}
            row |= first_times(collection.every(scene, model, experiment))
        runs = collection.every(scene, model, experiment)
        row["change"] = np.fmax.reduce(
            [float(scalar(run, "change")) for run in runs], initial=np.nan
        )
        made.append({name: row[name] for name in names if name in row})
    return made


def first_times(runs: list[xr.Dataset | None]) -> dict[str, float]:
    """Earliest time [s] at which a seed failed, and at which one that has values left its training
    range.
    """
    times: dict[str, list[float]] = {"failed_at_s": [], "left_range_at_s": []}
    for run in runs:
        ended, when = outcome(run), float(scalar(run, "failed_at"))
        if ended is not Outcome.OK and np.isfinite(when):
            times["left_range_at_s" if ended.has_value else "failed_at_s"].append(when)
    return {name: min(found, default=np.nan) for name, found in times.items()}
