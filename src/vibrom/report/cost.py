"""What accuracy costs in time, as tables: settings of the full order, settings of the methods,
break-even, and the cheapest setting for an error.

A scene that was not studied has one row with the outcome `not run`. Break-even needs no study: its
times are those of `run_times`.
"""

import numpy as np
import pandas as pd
import xarray as xr

from vibrom.report.collection import FULL_ORDER, UNSEEDED, Collection
from vibrom.report.scores import Scores, spread, tally
from vibrom.studies.work_precision import break_even, cheapest
from vibrom.thesis import published as thesis

FULL_ORDER_TARGETS, TARGETS = (1.0, 0.1, 0.01), (10.0, 5.0, 1.0)  # %
QUESTIONS = {"decay": "decays", "forced": "forced_runs", "frc": "sweeps"}
ERROR = {"decay": "nmte_percent", "forced": "nmte_percent", "frc": "amplitude_error_median_percent"}
OFFLINE = ("generate_training_data_s", "obtain_mapping_s", "obtain_dynamics_s")
CONFIGURED = "as configured"


def studied(collection: Collection, what: str) -> dict[str, xr.Dataset]:
    """Scene -> its study `cost_full_order` or `cost_reduced`."""
    found = {scene: collection.find(scene, FULL_ORDER, what) for scene in collection.scenes}
    return {scene: dataset for scene, dataset in found.items() if dataset is not None}


def without(collection: Collection, what: str, columns: list[str]) -> list[dict]:
    """A row for each scene that was not studied."""
    known = studied(collection, what)
    return [
        {
            "case": scene,
            "method": FULL_ORDER,
            **dict.fromkeys(columns, np.nan),
            "outcome": "not run",
        }
        for scene in collection.scenes
        if scene not in known
    ]


def answers(dataset: xr.Dataset, index: int) -> dict[str, tuple[float, float, str]]:
    """Question -> (error [%], seconds, outcome) of one setting."""
    row = dataset.isel(setting=index)
    return {
        str(name): (float(error), float(seconds), str(outcome))
        for name, error, seconds, outcome in zip(
            dataset["question"].values,
            row["error"].values,
            row["seconds"].values,
            row["outcome"].values,
        )
    }


# The full order

ABOUT = {
    "study": "study",
    "element": "element",
    "columns": "columns",
    "rows": "rows",
    "free_dofs": "free_dofs",
    "steps_per_period": "steps_per_period",
    "alpha": "alpha",
    "initial_acceleration": "initial_acceleration",
    "residual": "residual",
    "first_frequency": "omega_1_rad_per_s",
}
OF_QUESTION = {
    "decay": ("decay_error_percent", "decay_s"),
    "forced": ("forced_error_percent", "forced_s"),
    "frequency": ("omega_1_error_percent", "assembly_s"),
    "response": ("response_error_percent", "response_s"),
}


def full_order(collection: Collection) -> pd.DataFrame:
    """One row a setting, and one with the estimated errors of the references."""
    columns = [*ABOUT.values(), *(name for names in OF_QUESTION.values() for name in names)]
    rows = []
    for scene, dataset in studied(collection, "cost_full_order").items():
        for index in range(dataset.sizes["setting"]):
            row = {"case": scene, "method": FULL_ORDER} | {
                column: dataset[name].values[index] for name, column in ABOUT.items()
            }
            given = answers(dataset, index)
            for name, (error, seconds) in OF_QUESTION.items():
                row |= {error: given[name][0], seconds: given[name][1]}
            rows.append(
                row
                | {
                    "outcome": tally(
                        outcome for _, _, outcome in given.values() if outcome != "not asked"
                    )
                }
            )
        own = {
            OF_QUESTION[str(name)][0]: float(value)
            for name, value in zip(dataset["question"].values, dataset["reference_error"].values)
        }
        rows.append(
            {"case": scene, "method": FULL_ORDER, "study": "reference", **own, "outcome": "ok"}
        )
    frame = pd.DataFrame(
        rows + without(collection, "cost_full_order", columns),
        columns=["case", "method", *columns, "outcome"],
    )
    return whole(frame, ("columns", "rows", "free_dofs", "steps_per_period"))


def whole(frame: pd.DataFrame, columns: tuple[str, ...]) -> pd.DataFrame:
    """The same with whole numbers as such."""
    return frame.assign(
        **{name: pd.array(frame[name].astype(float), dtype="Int64") for name in columns}
    )


# The methods


def reduced(collection: Collection) -> pd.DataFrame:
    """One row a setting and seed."""
    columns = ["seed", "varied", "set_to", "data_s", "mapping_s", "dynamics_s"]
    columns += [
        f"{name}_{what}" for name in QUESTIONS for what in ("error_percent", "s", "outcome")
    ]
    rows = []
    for scene, dataset in studied(collection, "cost_reduced").items():
        for index in range(dataset.sizes["setting"]):
            one = dataset.isel(setting=index)
            seed = int(one["model_seed"])
            row = {
                "case": scene,
                "method": str(one["model"].values),
                "seed": UNSEEDED if seed < 0 else str(seed),
                "varied": str(one["varied"].values),
                "set_to": str(one["value"].values),
                **{
                    f"{name}_s": float(one[f"{name}_seconds"])
                    for name in ("data", "mapping", "dynamics")
                },
            }
            given = answers(dataset, index)
            for name, (error, seconds, outcome) in given.items():
                row |= {
                    f"{name}_error_percent": error,
                    f"{name}_s": seconds,
                    f"{name}_outcome": outcome,
                }
            rows.append(row | {"outcome": tally(outcome for _, _, outcome in given.values())})
    return pd.DataFrame(
        rows + without(collection, "cost_reduced", columns),
        columns=["case", "method", *columns, "outcome"],
    )


def settings(frame: pd.DataFrame) -> pd.DataFrame:
    """The table of `reduced` with seeds drawn together: medians, a failed seed counting as
    infinitely wrong; `offline_s` is their whole.
    """
    rows = []
    asked = frame[frame["outcome"] != "not run"]
    for (scene, method, varied, set_to), group in asked.groupby(
        ["case", "method", "varied", "set_to"], sort=False
    ):
        row = {
            "case": scene,
            "method": method,
            "varied": varied,
            "set_to": set_to,
            "seeds": len(group),
            "fit_s": float((group["mapping_s"] + group["dynamics_s"]).median()),
            "offline_s": float(group[["data_s", "mapping_s", "dynamics_s"]].sum(axis=1).median()),
        }
        for name in QUESTIONS:
            row |= {
                f"{name}_error_percent": spread(
                    group[f"{name}_error_percent"].to_numpy(float), worst=True
                ).median,
                f"{name}_s": spread(group[f"{name}_s"].to_numpy(float), worst=False).median,
            }
        rows.append(row)
    names = [
        "case",
        "method",
        "varied",
        "set_to",
        "seeds",
        "fit_s",
        "offline_s",
        *(f"{name}_{what}" for name in QUESTIONS for what in ("error_percent", "s")),
    ]
    return pd.DataFrame(rows, columns=names)


# Cheapest


def cheapest_settings(collection: Collection) -> pd.DataFrame:
    """For each question and error the setting that has it for the least seconds: of one run of the
    full order, whose reference's own error is added; of the training and one answer of a method.
    """
    rows = []
    for scene, dataset in studied(collection, "cost_full_order").items():
        own = dict(
            zip(dataset["question"].values.tolist(), dataset["reference_error"].values.tolist())
        )
        for question in OF_QUESTION:
            place = {"question": question}
            error = dataset["error"].sel(place).values + own[question]
            seconds = dataset["seconds"].sel(place).values
            for target in FULL_ORDER_TARGETS:
                found = cheapest(seconds, error, target)
                said = (
                    {}
                    if found is None
                    else {
                        "error_percent": error[found],
                        "online_s": seconds[found],
                        "setting": described(dataset.isel(setting=found), question),
                    }
                )
                rows.append(reached(scene, FULL_ORDER, question, target, said))
    table = settings(reduced(collection))
    for (scene, method), group in table.groupby(["case", "method"], sort=False):
        for question in QUESTIONS:
            error, online = (
                group[f"{question}_{what}"].to_numpy(float) for what in ("error_percent", "s")
            )
            offline = group["offline_s"].to_numpy(float)
            for target in TARGETS:
                found, said = cheapest(offline + online, error, target), {}
                if found is not None:
                    varied, set_to = group["varied"].iloc[found], group["set_to"].iloc[found]
                    said = {
                        "error_percent": error[found],
                        "offline_s": offline[found],
                        "online_s": online[found],
                        "setting": f"{varied} {set_to}".strip(),
                    }
                rows.append(reached(scene, method, question, target, said))
    columns = ["error_percent", "offline_s", "online_s", "setting"]
    missing = (
        []
        if rows
        else without(collection, "cost_full_order", ["question", "target_percent", *columns])
    )
    return pd.DataFrame(
        rows + missing,
        columns=["case", "method", "question", "target_percent", *columns, "outcome"],
    )


def reached(scene: str, method: str, question: str, target: float, said: dict) -> dict:
    return {
        "case": scene,
        "method": method,
        "question": question,
        "target_percent": target,
        **said,
        "outcome": "ok" if said else "not reached",
    }


def described(row: xr.Dataset, question: str) -> str:
    """A setting of the full order in words."""
    steps = f"T/{int(row['steps_per_period'])}"
    if str(row["study"].values) == "mesh":
        mesh = f"{row['element'].values} {int(row['columns'])} x {int(row['rows'])}"
        return mesh if question == "frequency" else f"{mesh}, {steps}"
    return f"{steps}, alpha {float(row['alpha']):g}, start {row['initial_acceleration'].values}, residual {float(row['residual']):g}"


# Break-even


def break_evens(collection: Collection, scores: Scores) -> pd.DataFrame:
    """After how many decays, forced runs and sweeps a method has paid for its training, with our
    times and with the thesis's; no number where the method does not answer the question.
    """
    rows = []
    for scene in collection.scenes:
        for method in collection.methods:

            def ours(quantity: str, model: str = method, scene: str = scene) -> float:
                return scores.spread(scene, model, "run_times", quantity, worst=False).median

            row = {
                "case": scene,
                "method": method,
                "offline_s": total([ours(name) for name in OFFLINE]),
            }
            for question, plural in QUESTIONS.items():
                answered = np.isfinite(
                    scores.spread(scene, method, question, ERROR[question]).median
                )
                row[plural] = (
                    break_even(
                        row["offline_s"], ours(f"{question}_s"), ours(f"{question}_s", FULL_ORDER)
                    )
                    if answered
                    else np.nan
                )
            printed = {name: thesis.run_time(name, scene, method) for name in thesis.RUN_TIMES}
            row["thesis_offline_s"] = total([printed[name] for name in OFFLINE])
            for question, plural in QUESTIONS.items():
                fails = (
                    thesis.percent(question, scene, method)[1] if question != "frc" else ""
                )  # of curves it prints no errors
                times = (
                    row["thesis_offline_s"],
                    printed[f"{question}_s"],
                    thesis.run_time(f"{question}_s", scene, FULL_ORDER),
                )
                row[f"thesis_{plural}"] = np.nan if fails else break_even(*times)
            rows.append(row | {"outcome": scores.outcome(scene, method, "run_times")})
    columns = [
        "offline_s",
        *QUESTIONS.values(),
        "thesis_offline_s",
        *(f"thesis_{plural}" for plural in QUESTIONS.values()),
    ]
    return pd.DataFrame(rows, columns=["case", "method", *columns, "outcome"])


def total(parts: list[float]) -> float:
    """Their sum; a part that a method does not have counts nothing."""
    return float(np.nansum(parts)) if np.isfinite(parts).any() else np.nan
