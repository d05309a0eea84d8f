"""What the links of `make ui` open: a table that compares, and charts.

MLflow keeps a shared view of an experiment as a tag `mlflow.sharedViewState.<key>`: name, times of
creation and update, and the state of the page as text. The key stands in the address.
"""

from __future__ import annotations

import json
import uuid
from collections.abc import Iterable
from typing import Any

TAG = "mlflow.sharedViewState."
ERRORS = {  # metric -> section of the charts
    "decay/nmte_percent": "errors",
    "forced/nmte_percent": "errors",
    "frc/amplitude_error_median_percent": "errors",
    "branches/folds": "errors",
    "branches/peak_error_percent": "errors",
}
SECONDS = ("offline_s", "run_times/decay_s")
OUTCOME, MODEL = "outcome", "model"  # tags: how the run ended; whose it is, as `folding split`
NAME = "attributes.`Run Name`"
SECTIONS = {"errors": "Errors", "cost": "Error and cost", "losses": "Losses"}
LOSS = "losses/train_total"
RUNS = 100  # that a chart compares


def address(host: str, experiment: str, key: str) -> str:
    """Of a view."""
    mode = "&compareRunsMode=CHART" if key == "charts" else ""
    return (
        f"{host}/#/experiments/{experiment}/runs?workflowType=machine_learning"
        f"&viewStateShareKey={key}{mode}"
    )


def tags(runs: Iterable[Any]) -> dict[str, str]:
    """The views of these runs, as tags of the experiment."""
    known = {name for run in runs for name in (*run.metrics, *run.curves)}
    errors = [name for name in ERRORS if name in known]
    seconds = [name for name in SECONDS if name in known]
    table = state(errors, seconds)
    # By one tag: a group of two parameters has a name that is longer than its column.
    average = {"groupBy": grouped("tag", MODEL), "useGroupedValuesInCharts": True}
    views = {
        "table": ("Scenes", table | {"groupBy": grouped("param", "scene")}),
        "methods": ("Methods, mean over seeds", table | average),
        "charts": ("Charts, mean over seeds", table | average | charts(errors, seconds)),
    }
    return {
        f"{TAG}{key}": json.dumps(
            {"name": name, "createdAt": 0, "updatedAt": 0, "state": json.dumps(view)}
        )
        for key, (name, view) in views.items()
    }


def grouped(mode: str, name: str) -> dict[str, Any]:
    """By this parameter or tag, with the mean of what is numeric."""
    keys = [{"mode": mode, "groupByData": name}]
    return {"aggregateFunction": "average", "groupByKeys": keys}


def state(errors: list[str], seconds: list[str]) -> dict[str, Any]:
    """Columns and order of the table; the summary has no scene and stays out."""
    columns = [f"params.`{name}`" for name in ("scene", "method", "seed")]
    columns += [f"tags.`{OUTCOME}`"]
    columns += [f"metrics.`{name}`" for name in (*errors, *seconds)]
    return {
        "searchFilter": "params.scene != ''",
        "orderByKey": f"metrics.`{errors[0]}`" if errors else "attributes.start_time",
        "orderByAsc": True,
        "startTime": "ALL",
        "lifecycleFilter": "Active",
        "datasetsFilter": [],
        "modelVersionFilter": "All Runs",
        "selectedColumns": columns,
        "columnOrder": [NAME, *columns],
        "columnWidths": dict.fromkeys(columns, 85) | {NAME: 290, "params.`method`": 160},  # [px]
        "runsHiddenMode": "SHOW_ALL",
        "groupsExpanded": {},
    }


def charts(errors: list[str], seconds: list[str]) -> dict[str, Any]:
    """Bars of the errors, errors over seconds, and the losses."""
    made = [chart("BAR", "errors", metricKey=name) for name in errors]
    for price in seconds:
        made += [
            chart("SCATTER", "cost", xaxis=axis(price), yaxis=axis(name)) for name in errors[:3]
        ]
    line = {"lineSmoothness": 0, "scaleType": "log", "xAxisKey": "step", "xAxisScaleType": "linear"}
    line |= {"range": {}, "yAxisKey": "metric", "yAxisExpressions": [], "ignoreOutliers": False}
    line |= {"selectedXAxisMetricKey": "", "useGlobalXaxisKey": True}
    line |= {"useGlobalLineSmoothing": True, "metricKey": LOSS, "selectedMetricKeys": [LOSS]}
    made.append(chart("LINE", "losses", **line))
    sections = [
        {"uuid": key, "name": name, "display": True, "isReordered": True}
        | {"deleted": False, "isGenerated": False}
        for key, name in SECTIONS.items()
    ]
    return {
        "compareRunCharts": made,
        "compareRunSections": sections,
        "isAccordionReordered": True,
        "hideEmptyCharts": True,
    }


def axis(name: str) -> dict[str, str]:
    """Of a chart."""
    return {"key": name, "type": "METRIC"}


def chart(kind: str, section: str, **more: Any) -> dict[str, Any]:
    """One of them."""
    identity = uuid.uuid5(uuid.NAMESPACE_URL, json.dumps([kind, section, more], sort_keys=True)).hex
    about = {"uuid": identity, "type": kind, "runsCountToCompare": RUNS}
    return about | {"metricSectionId": section, "deleted": False, "isGenerated": False} | more
