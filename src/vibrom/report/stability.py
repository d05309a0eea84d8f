"""Hard cases in numbers: how many runs of the grid hold, what each guard does to the scene's own
questions, and the full order at coarse steps.

Shares of runs carry Wilson's interval of 95 % (Wilson, J. Am. Stat. Assoc. 22 (1927) 209).
"""

from collections.abc import Iterator

import numpy as np
import pandas as pd
import xarray as xr
from scipy.stats import binomtest

from vibrom.artefacts.data import FINISHED
from vibrom.report.collection import FULL_ORDER, Collection
from vibrom.report.scores import spread, tally
from vibrom.studies.grid import rises

NOT_RUN = "not run"
OUTCOMES = ("ok", "left_range", "diverged", "step_underflow", "no_convergence")


def outcomes(collection: Collection) -> pd.DataFrame:
    """One row a case, model, guard and integrator: all runs of the grid over all seeds."""
    rows = []
    for scene, method, guard, integrator, answers in answered(collection):
        ended = np.concatenate([answer["outcome"].values for answer in answers])
        failed_at = np.concatenate([answer["failed_at"].values for answer in answers])
        held = np.isin(ended, FINISHED)
        counts = {word: int((ended == word).sum()) for word in OUTCOMES}
        runs = sum(counts.values())
        share, low, high = held_share(int(held.sum()), runs)
        rows.append(
            {
                "case": scene,
                "method": method,
                "guard": guard,
                "integrator": integrator,
                "runs": runs,
                **counts,
                "not_asked": len(ended) - runs,
                "held_percent": share,
                "held_low_percent": low,
                "held_high_percent": high,
                "median_failure_periods": median(failed_at[~held]),
                "largest_range_ratio": np.nanmax(
                    np.append(ranges(answers)[held], np.nan), initial=0.0
                )
                if held.any()
                else np.nan,
                "outcome": tally(ended),
            }
        )
    return pd.DataFrame(
        rows,
        columns=[
            "case",
            "method",
            "guard",
            "integrator",
            "runs",
            *OUTCOMES,
            "not_asked",
            "held_percent",
            "held_low_percent",
            "held_high_percent",
            "median_failure_periods",
            "largest_range_ratio",
            "outcome",
        ],
    )


def held_share(held: int, runs: int) -> tuple[float, float, float]:
    """Percentage, and the ends of its interval; a model that could not be fitted or guarded was
    asked nothing and has none.
    """
    if runs == 0:
        return np.nan, np.nan, np.nan
    share = binomtest(held, runs)
    interval = share.proportion_ci(method="wilson")
    return 100 * share.statistic, 100 * interval.low, 100 * interval.high


def was_asked(answer: xr.Dataset) -> bool:
    """Whether there was a model, with this guard, to ask."""
    return bool(np.isin(answer["outcome"].values, OUTCOMES).any())


def ranges(answers: list[xr.Dataset]) -> np.ndarray:
    return np.concatenate([answer["range_ratio"].values for answer in answers])


def guards(collection: Collection) -> pd.DataFrame:
    """One row a case, model, guard and integrator: the scene's response curve, decay and forced
    run, and whether decays lose energy.
    """
    rows = []
    for scene, method, guard, integrator, answers in answered(collection):
        truth = collection.find(scene, FULL_ORDER, "frc")["amplitude"].values[0]
        curves = [compared(answer["frc_amplitude"].values, truth) for answer in answers]
        median_error, peak_error, peak_steps = (np.array(column) for column in zip(*curves))
        row = {
            "case": scene,
            "method": method,
            "guard": guard,
            "integrator": integrator,
            "seeds": len(answers),
            "points": len(truth) * len(answers),
            "points_with_value": int(
                sum(np.isfinite(answer["frc_amplitude"].values).sum() for answer in answers)
            ),
        }
        for name, values, worst in (
            ("median_amplitude_error_percent", median_error, True),
            ("peak_error_percent", peak_error, False),
            ("peak_steps", peak_steps, False),
            ("decay_nmte_percent", [float(answer["decay_nmte"]) for answer in answers], True),
            ("forced_nmte_percent", [float(answer["forced_nmte"]) for answer in answers], True),
            ("real_per_s", [float(answer["real_part"]) for answer in answers], False),
        ):
            found = spread(np.array(values), worst=worst)
            row |= {name: found.median, f"{name}_min": found.minimum, f"{name}_max": found.maximum}
        let_go = [
            answer
            for answer in answers
            if integrator == answer.attrs["first"] and was_asked(answer)
        ]
        row["decays"] = sum(answer.sizes["release"] for answer in let_go)
        for name in ("energy", "envelope"):
            row[f"{name}_rises"] = (
                int(sum(rises(answer[name].values).sum() for answer in let_go))
                if let_go
                else np.nan
            )
        rows.append(
            row
            | {
                "outcome": tally(
                    np.concatenate([answer["frc_outcome"].values for answer in answers])
                )
            }
        )
    return (
        pd.DataFrame(rows)
        if rows
        else pd.DataFrame(
            columns=[
                "case",
                "method",
                "guard",
                "integrator",
                "points",
                "points_with_value",
                "outcome",
            ]
        )
    )


def compared(amplitude: np.ndarray, truth: np.ndarray) -> tuple[float, float, float]:
    """(median amplitude error [%], error of the peak [%], places between the peaks) of a curve; a
    failed point is infinitely wrong, and a curve with gaps has no peak.
    """
    known = np.isfinite(truth)
    error = 100 * np.abs(amplitude - truth) / np.abs(truth)
    middle = (
        float(np.median(np.where(np.isfinite(error), error, np.inf)[known]))
        if known.any()
        else np.nan
    )
    if not (np.isfinite(amplitude).all() and known.all()):
        return middle if np.isfinite(middle) else np.nan, np.nan, np.nan
    return (
        middle,
        100 * (amplitude.max() / truth.max() - 1),
        float(abs(int(amplitude.argmax()) - int(truth.argmax()))),
    )


def full_order(collection: Collection) -> pd.DataFrame:
    """One row a case, number of steps, numerical damping and forcing; errors against the scene's
    own response curve where the forcing is the scene's.
    """
    rows = []
    for scene in collection.scenes:
        answer = collection.find(scene, FULL_ORDER, "stability")
        if answer is None:
            continue
        truth = answer["reference"].values
        for index in np.ndindex(
            *(answer.sizes[name] for name in ("steps_per_period", "alpha", "forcing"))
        ):
            part = answer.isel(dict(zip(("steps_per_period", "alpha", "forcing"), index)))
            error = (
                compared(part["amplitude"].values, truth)
                if float(part["forcing"]) == 1.0
                else (np.nan,) * 3
            )
            rows.append(
                {
                    "case": scene,
                    "method": FULL_ORDER,
                    "steps_per_period": int(part["steps_per_period"]),
                    "gamma": 0.5 + float(part["alpha"]),
                    "forcing": float(part["forcing"]),
                    "points": len(truth),
                    "points_with_value": int(np.isfinite(part["amplitude"].values).sum()),
                    "median_amplitude_error_percent": error[0],
                    "peak_error_percent": error[1],
                    "median_failure_periods": median(part["failed_at"].values),
                    "seconds": float(part["seconds"]),
                    "outcome": tally(part["outcome"].values),
                }
            )
    return pd.DataFrame(
        rows,
        columns=[
            "case",
            "method",
            "steps_per_period",
            "gamma",
            "forcing",
            "points",
            "points_with_value",
            "median_amplitude_error_percent",
            "peak_error_percent",
            "median_failure_periods",
            "seconds",
            "outcome",
        ],
    )


def answered(collection: Collection) -> Iterator[tuple[str, str, str, str, list[xr.Dataset]]]:
    """Scene, method, guard, integrator and what each seed answered; pairs that were not asked are
    left out.
    """
    for scene in collection.scenes:
        for method in collection.methods:
            found = [
                collection.find(scene, method, "stability", seed)
                for seed in collection.seeds(scene, method)
            ]
            found = [answer for answer in found if answer is not None]
            if not found:
                continue
            for guard in found[0]["guard"].values:
                for integrator in found[0]["integrator"].values:
                    chosen = [
                        answer.sel(guard=guard, integrator=integrator).assign_attrs(
                            first=str(answer["integrator"].values[0])
                        )
                        for answer in found
                    ]
                    if not (chosen[0]["outcome"].values == NOT_RUN).all():
                        yield scene, method, str(guard), str(integrator), chosen


def median(values: np.ndarray) -> float:
    good = np.asarray(values, float)[np.isfinite(values)]
    return float(np.median(good)) if good.size else np.nan
