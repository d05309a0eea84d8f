"""Every prediction's scores -> scores.csv, the long form: scene, method, seed, experiment, metric,
value, unit, seconds, outcome.
"""

from collections import Counter
from pathlib import Path

import pandas as pd
import xarray as xr

from vibrom.artefacts.data import UNSEEDED
from vibrom.steps._files import write

COLUMNS = ["scene", "method", "seed", "experiment", "metric", "value", "unit", "seconds", "outcome"]


def run(*, predictions: list[str], scores: str, provenance: dict) -> None:
    rows = []
    for path in predictions:
        with xr.open_dataset(path, engine="netcdf4") as dataset:
            outcomes = Counter(str(word) for word in dataset["outcome"].values.ravel())
            outcome = (
                next(iter(outcomes))
                if len(outcomes) == 1
                else ", ".join(f"{word} {count}" for word, count in sorted(outcomes.items()))
            )
            seed = int(dataset.attrs["seed"])
            for metric, value, unit in zip(
                dataset["score"].values, dataset["score_value"].values, dataset["score_unit"].values
            ):
                rows.append(
                    [
                        dataset.attrs["scene"],
                        dataset.attrs["method"],
                        "unseeded" if seed == UNSEEDED else seed,
                        Path(path).stem,
                        metric,
                        value,
                        unit,
                        float(dataset["seconds"]),
                        outcome,
                    ]
                )
    write(scores, pd.DataFrame(rows, columns=COLUMNS).to_csv(index=False, float_format="%.10g"))
