# From the artefacts of all models to scores, the report and MLflow.
# Tables and figures are files in src/vibrom/report/tables and figures; their constants say what the workflow must know.
from typing import NamedTuple

from vibrom.report import outputs

# Every model of the run as (scene, method, seed folder).
MODELS = [
    (scene, method, seed)
    for scene in SCENES
    for method in METHODS
    for seed in SETTINGS.seed_folders(method)
]


def of_full_order(scenes, names):
    return [
        f"<results>/{scene}/{settings.FULL_ORDER}/{name}.nc" for scene in scenes for name in names
    ]


def of_models(scenes, names):
    return [
        f"<results>/{'/'.join(model)}/{name}.nc"
        for model in MODELS
        if model[0] in scenes
        for name in names
    ]


ASKED = [name for name in SETTINGS.experiments if EXPERIMENTS[name]["of_full_order"]]
PREDICTIONS = of_models(SCENES, SETTINGS.experiments) + of_full_order(SCENES, ASKED)
FITTED = of_models(SCENES, ("rom", "losses"))
ARTEFACTS = of_full_order(SCENES, FULL_ORDER_NAMES) + FITTED + PREDICTIONS


def studied(study):
    """The scenes of this run that a study is about."""
    block = SETTINGS.studies.get(study)
    return [] if block is None else [name for name in block.get("scenes", SCENES) if name in SCENES]


COST_NAMES = [*FULL_ORDER_NAMES, "cost_full_order", "cost_reduced"]
ROBUSTNESS = of_full_order(studied("robustness"), ["frc", "robustness"])
ROBUSTNESS += of_models(studied("robustness"), ["robustness"])


class Family(NamedTuple):
    """Tables and figures that are made from one set of artefacts."""

    scenes: list  # a family without scenes has no tables and figures
    artefacts: list


FAMILIES = {
    # What guards promise is among the checks.
    "models": Family(list(SCENES), ARTEFACTS + ROBUSTNESS),
    "cost": Family(studied("cost"), of_full_order(studied("cost"), COST_NAMES)),
    "ablation": Family(studied("ablation"), of_full_order(studied("ablation"), ["ablation"])),
    "robustness": Family(studied("robustness"), ROBUSTNESS),
}
for NAME in outputs.families():
    if NAME not in FAMILIES:
        sys.exit(f"vibrom: FAMILY {NAME!r} of a table or figure: choose from {', '.join(FAMILIES)}")
PRESENT = [name for name, family in FAMILIES.items() if family.scenes]
TABLES = {name: outputs.tables(name, SETTINGS.experiments) for name in PRESENT}
FIGURES = {name: outputs.figures(name, FAMILIES[name].scenes) for name in PRESENT}
MADE = {"tables": TABLES, "figures": FIGURES}


def files(kind, families=PRESENT, forms=None):
    """The tables or figures of these families, in these formats or in all."""
    return [
        f"<results>/{kind}/{name}.{form}"
        for family in families
        for name in MADE[kind].get(family, ())
        for form in forms or outputs.FORMATS[kind]
    ]


def modules(kind, families=PRESENT):
    """The code behind them."""
    return [module for family in families for module in outputs.modules(kind, family)]


def all_artefacts():
    """Of all families, each once."""
    return list(dict.fromkeys(path for name in PRESENT for path in FAMILIES[name].artefacts))


def plugs_shown(kind):
    """The tables by name, the figures by the file that draws them."""
    if kind == "tables":
        return [name for names in TABLES.values() for name in names]
    return list(
        dict.fromkeys(drawing.plug for names in FIGURES.values() for drawing in names.values())
    )


rule scores:
    input:
        predictions=PREDICTIONS,
    output:
        scores="<results>/scores.csv",
    log:
        "<logs>/scores.log",
    params:
        provenance=code("scores"),
    message:
        "scores of all models"
    script:
        "../scripts/step.py"


rule report:
    input:
        artefacts=all_artefacts(),
        figures=files("figures", forms=("svg", "png")),
    output:
        report="<results>/report.html",
    log:
        "<logs>/report.log",
    params:
        tables_shown=plugs_shown("tables"),
        captions=outputs.captions({kind: plugs_shown(kind) for kind in MADE}),
        provenance=code("report", *modules("tables")),
    message:
        "report"
    script:
        "../scripts/step.py"


rule tracking:
    input:
        artefacts=FITTED + PREDICTIONS,
        scores=rules.scores.output.scores,
        tables=files("tables"),
        figures=files("figures"),
    output:
        store="<results>/mlflow.db",
        artifacts=directory("<results>/mlflow_artifacts"),
    log:
        "<logs>/tracking.log",
    benchmark:
        "<benchmarks>/tracking.tsv"
    params:
        provenance=code("tracking"),
    message:
        "MLflow store"
    script:
        "../scripts/step.py"


rule headline:
    input:
        artefacts=FAMILIES["models"].artefacts,
        report=rules.report.output.report,
        # Last of all: what it prints is the end of the run.
        store=rules.tracking.output.store,
    output:
        headline="<results>/headline.txt",
    log:
        "<logs>/headline.log",
    params:
        provenance=code("headline", *modules("tables", ["models"])),
    message:
        "headline numbers"
    script:
        "../scripts/step.py"
