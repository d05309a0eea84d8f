"""The work balance of every run

What the energy of the body changes by, less the work of the loads, plus what damping and other
forces without a potential take, relative to all energy that was there or went through: zero for the
equations of motion. The full order's runs break it by their numerical damping and the errors of
their steps. The motions of the models are inserted into the body's own energy: a model whose shapes
are off a little may be off far in energy, as a body is much stiffer along its length than across
it. Largest value over the points of a curve or the realisations of noise; over seeds the median,
smallest and largest. Runs beyond the tolerance (``balance`` of the
scene's ``record`` and experiments, ``studies.trust.tolerance``) are ``unbalanced``; no value: the
run did not last.
"""

from vibrom.artefacts.outcome import Tally
from vibrom.report.columns import CASE, METHOD, OUTCOME, SEEDS, Column
from vibrom.report.scores import BALANCE

FAMILY = "models"
PLACE = 95
ALSO = ["trust"]  # of the models
COLUMNS = (
    CASE,
    METHOD,
    Column("run", "Run"),
    Column("balance_percent", "Work balance [%]", spread=True),
    SEEDS,
    OUTCOME,
)


def build(collection, scores):
    """One row a case, model and run."""
    rows = []
    for scene, model in collection.models:
        found = scores.of_experiment(scene, model, BALANCE)
        for metric in dict.fromkeys(score.metric for score in found):
            mine = [score for score in found if score.metric == metric]
            columns = scores.spread(scene, model, BALANCE, metric).columns("balance_percent")
            about = {"case": scene, "method": model, "run": metric.removesuffix("_percent")}
            ended = Tally(word for score in mine for word in score.outcome.elements())
            rows.append(about | {"seeds": len(mine)} | columns | {"outcome": ended})
    return rows
