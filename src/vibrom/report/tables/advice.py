"""Which effects a scene needs

The largest set of effects that may be left out together: without them the decay from the test
release and the forced amplitudes of all probes stay within the tolerance of the study
(``studies.ablation.tolerance``); the error is the larger of the NMTE of the decay and the change
of an amplitude over the largest one. Errors of two effects may add up or cancel, so that sets are
tried, and not only single effects. The time of a step with these effects over that without them is
the median over turns. A load is always needed: without it nothing is forced.
"""

from vibrom.report.collection import FULL_ORDER, described
from vibrom.report.columns import CASE, Column
from vibrom.report.table import printed

FAMILY = "ablation"
PLACE = 205
COLUMNS = (
    CASE,
    Column("tolerance_percent", "Tolerance [%]"),
    Column("needed", "Needed"),
    Column("left_out", "May be left out"),
    Column("error_percent", "Error without it [%]"),
    Column("seconds_ratio", "With / without [–]"),
    Column("sets_tried", "Sets tried", whole=True),
)


def shown(rows, columns):
    """None is the reference."""
    return printed(rows, columns, lambda row: "")


def build(collection, scores):
    """One row a case."""
    rows = []
    for scene in collection.scenes:
        study = collection.find(scene, FULL_ORDER, "ablation")
        if study is not None and "advised" in study:
            left_out = str(study["advised"].item()).split()
            listed = described(collection.find(scene, FULL_ORDER, "structure"), "effects")
            rows.append(
                {
                    "case": scene,
                    "tolerance_percent": 100.0 * float(study.attrs["tolerance"]),
                    "needed": ", ".join(name for name in listed if name not in left_out),
                    "left_out": ", ".join(left_out) or "nothing",
                    "error_percent": float(study["advised_error"]),
                    "seconds_ratio": float(study["advised_ratio"]),
                    "sets_tried": int(study["sets_tried"]),
                }
            )
    return rows
