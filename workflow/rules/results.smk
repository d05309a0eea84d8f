# From the artefacts of all models to scores, tables, figures, the report and MLflow.
from vibrom.report import names as shown_names

CAPTIONS = ROOT / "workflow/report"

# Every model of the run as (scene, method, seed folder).
MODELS = [
    (scene, method, seed)
    for scene in SCENES
    for method in METHODS
    for seed in SETTINGS.seed_folders(method)
]
PREDICTIONS = [
    f"<results>/{'/'.join(model)}/{name}.nc" for model in MODELS for name in SETTINGS.experiments
] + [
    f"<results>/{scene}/{settings.FULL_ORDER}/{name}.nc"
    for scene in SCENES
    for name in SETTINGS.experiments
    if EXPERIMENTS[name].get("full_order") is not None
]
FITTED = [
    f"<results>/{'/'.join(model)}/{name}.nc" for model in MODELS for name in ("rom", "losses")
]
FULL_ORDER_FILES = [
    f"<results>/{scene}/{settings.FULL_ORDER}/{name}.nc"
    for scene in SCENES
    for name in FULL_ORDER_NAMES
]
ARTEFACTS = FULL_ORDER_FILES + FITTED + PREDICTIONS
EFFECTS_FILES = [f"<results>/{scene}/{settings.FULL_ORDER}/effects.nc" for scene in SCENES]
HARD = SETTINGS.studies.get("robustness", {"scenes": []})["scenes"]
HARD_FILES = [
    f"<results>/{'/'.join(model)}/stability.nc" for model in MODELS if model[0] in HARD
] + [
    f"<results>/{scene}/{settings.FULL_ORDER}/{name}.nc"
    for scene in HARD
    for name in ("stability", "frc")
]

# Which scenes each family of tables and figures is about; a family without scenes has none.
ASKED = {"models": list(SCENES), "cost": COST_SCENES, "effects": list(SCENES), "stability": HARD}


def asked(families):
    return [family for family in families or ASKED if ASKED[family]]


def table_files(*families):
    """The tables of these families, in all their formats; of all, where none is named."""
    return [
        f"<results>/tables/{name}.{form}"
        for family in asked(families)
        for name in shown_names.tables(family)
        for form in shown_names.TABLE_FORMATS
    ]


def figure_files(*families):
    return [
        f"<results>/figures/{name}.{form}"
        for family in asked(families)
        for name in shown_names.figures(ASKED[family], family)
        for form in shown_names.FIGURE_FORMATS
    ]


def in_report(paths):
    """The same as outputs: tables as .html and figures as .svg appear in Snakemake's report, with their captions."""

    def flagged(path):
        kind, name, form = Path(path).parent.name, Path(path).stem, Path(path).suffix
        if form not in (".html", ".svg"):
            return path
        caption = name if kind == "tables" else shown_names.split(name)[0]
        return report(
            path,
            caption=f"../report/{kind}/{caption}.rst",
            category=kind.capitalize(),
            labels={kind[:-1]: name.replace("_", " ")},
        )

    return [flagged(path) for path in paths]


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
        scores=rules.scores.output.scores,
        artefacts=ARTEFACTS + COST_ARTEFACTS + EFFECTS_FILES,
        tables=table_files(),
        figures=figure_files(),
        captions=[f"{CAPTIONS}/{name}" for name in shown_names.captions()],
    output:
        report="<results>/report.html",
    log:
        "<logs>/report.log",
    params:
        provenance=code("report"),
    message:
        "report"
    script:
        "../scripts/step.py"


rule tracking:
    input:
        scores=rules.scores.output.scores,
        fitted=FITTED,
        tables=table_files(),
        figures=figure_files(),
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
        # Last of all: what it prints is the end of the run.
        rules.tracking.output.store,
        scores=rules.scores.output.scores,
        report=rules.report.output.report,
        tables=table_files(),
    output:
        headline="<results>/headline.txt",
    log:
        "<logs>/headline.log",
    params:
        provenance=code("headline"),
    message:
        "headline numbers"
    script:
        "../scripts/step.py"
