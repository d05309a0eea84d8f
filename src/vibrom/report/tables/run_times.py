"""Table 3.6: run times

Wall time, offline (training data, mapping, dynamics) and online (one decay, one forced run, one
response curve of all its frequencies), in seconds; loading, compilation and warm-up are excluded.
Each time of a reduced model is the best of up to three calls, those of the full order are of one
run, and another job may have run on the other core meanwhile. Median over seeds, smallest and
largest in parentheses. The number in square brackets is the thesis's, from another machine and
other software; it prints one for all three cases. Methods whose mapping and dynamics are learnt
together have their time under mapping.
"""

from functools import partial

from vibrom.report.columns import (
    CASE,
    METHOD,
    OUTCOME,
    SEEDS,
    Column,
    Row,
    as_given,
    hidden,
    missing,
    over_seeds,
)
from vibrom.report.scores import Spread, endings
from vibrom.thesis import published as thesis

FAMILY = "models"
PLACE = 60
ASKED = "run_times"  # where that is asked only
HEADINGS = {
    "generate_training_data_s": "Training data [s]",
    "obtain_mapping_s": "Mapping [s]",
    "obtain_dynamics_s": "Dynamics [s]",
    "decay_s": "Decay [s]",
    "forced_s": "Forced run [s]",
    "frc_s": "Response curve [s]",
}


def beside_the_thesis(row: Row, name: str) -> str:
    """`0.012 (0.011 to 0.013) [0.2]`."""
    ours = over_seeds(Spread(row[name], row[f"{name}_min"], row[f"{name}_max"]))
    theirs = row[f"thesis_{name}"]
    return ours if missing(theirs) else f"{ours} [{as_given(theirs)}]"


COLUMNS = (
    CASE,
    METHOD,
    *(
        Column(name, heading, spread=True, text=partial(beside_the_thesis, name=name))
        for name, heading in HEADINGS.items()
    ),
    *hidden(*(f"thesis_{name}" for name in HEADINGS)),
    SEEDS,
    OUTCOME,
)


def build(collection, scores):
    """One row a case and model."""
    rows = []
    for scene, model in collection.models:
        row = {"case": scene, "method": model, "seeds": len(collection.seeds(scene, model))}
        for name in HEADINGS:
            row |= scores.spread(scene, model, "run_times", name, worst=False).columns(name)
            row[f"thesis_{name}"] = thesis.run_time(name, scene, model)
        rows.append(row | {"outcome": endings(collection, scores, scene, model, "run_times")})
    return rows
