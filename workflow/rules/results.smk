# From the artefacts of all models to scores, tables, figures, the report and MLflow.
from vibrom.report.names import FIGURE_FORMATS, STABILITY_TABLES, TABLE_FORMATS, TABLES, of_family, stability_figures
from vibrom.report.names import captions as caption_names
from vibrom.report.names import figures as figure_names
from vibrom.report.names import split as figure_group

CAPTIONS = ROOT / "workflow/report"

# Every model of the run as (scene, method, seed folder).
MODELS = [(scene, method, seed) for scene in SCENES for method in METHODS for seed in SETTINGS.seed_folders(method)]
PREDICTIONS = [f"<results>/{'/'.join(model)}/{name}.nc" for model in MODELS for name in SETTINGS.experiments] + [
    f"<results>/{scene}/{settings.FULL_ORDER}/{name}.nc"
    for scene in SCENES
    for name in SETTINGS.experiments
    if EXPERIMENTS[name].get("full_order") is not None
]
FITTED = [f"<results>/{'/'.join(model)}/{name}.nc" for model in MODELS for name in ("rom", "losses")]
FULL_ORDER_FILES = [
    f"<results>/{scene}/{settings.FULL_ORDER}/{name}.nc" for scene in SCENES for name in FULL_ORDER_NAMES
]
ARTEFACTS = FULL_ORDER_FILES + FITTED + PREDICTIONS + COST_ARTEFACTS
EFFECTS_FILES = [f"<results>/{scene}/{settings.FULL_ORDER}/effects.nc" for scene in SCENES]

# The grid of hard cases has rules of its own; what they show is part of the page.
HARD = SETTINGS.stability["scenes"]
HARD_TABLES = [f"<results>/tables/{name}.{form}" for name in STABILITY_TABLES if HARD for form in TABLE_FORMATS]
HARD_FIGURES = [f"<results>/figures/{name}.{form}" for name in stability_figures(HARD) for form in FIGURE_FORMATS]


def shown(path, kind, name):
    """An output that appears in Snakemake's report, with its caption."""
    caption = name if kind == "tables" else figure_group(name)[0]
    return report(
        path,
        caption=f"../report/{kind}/{caption}.rst",
        category=kind.capitalize(),
        labels={kind[:-1]: name.replace("_", " ")},
    )


def table_files(family=None):
    """The tables of a family of experiments, or of the reduced models."""
    return [
        shown(path, "tables", name) if form == "html" else path
        for name in of_family("tables", family, TABLES)
        for form in TABLE_FORMATS
        for path in [f"<results>/tables/{name}.{form}"]
    ]


def figure_files(family=None):
    return [
        shown(path, "figures", name) if form == "svg" else path
        for name in of_family("figures", family, figure_names(SCENES))
        for form in FIGURE_FORMATS
        for path in [f"<results>/figures/{name}.{form}"]
    ]


ALL_TABLES = [f"<results>/tables/{name}.{form}" for name in TABLES for form in TABLE_FORMATS]
ALL_FIGURES = [f"<results>/figures/{name}.{form}" for name in figure_names(SCENES) for form in FIGURE_FORMATS]


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


rule tables:
    input:
        scores=rules.scores.output.scores,
        artefacts=ARTEFACTS,
    output:
        tables=table_files(),
    log:
        "<logs>/tables.log",
    params:
        provenance=code("tables"),
    message:
        "tables"
    script:
        "../scripts/step.py"


rule figures:
    input:
        scores=rules.scores.output.scores,
        artefacts=ARTEFACTS,
    output:
        figures=figure_files(),
    log:
        "<logs>/figures.log",
    benchmark:
        "<benchmarks>/figures.tsv"
    params:
        provenance=code("figures"),
    message:
        "figures"
    script:
        "../scripts/step.py"


rule report:
    input:
        scores=rules.scores.output.scores,
        artefacts=ARTEFACTS + EFFECTS_FILES,
        tables=ALL_TABLES + HARD_TABLES,
        figures=ALL_FIGURES + HARD_FIGURES,
        captions=[f"{CAPTIONS}/{name}" for name in caption_names(SCENES)],
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
        tables=ALL_TABLES,
        figures=ALL_FIGURES,
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
        tables=ALL_TABLES,
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


rule cost:
    localrule: True
    input:
        [f"<results>/tables/{name}.csv" for name in TABLES if name.startswith(("cost_", "cheapest", "break_even"))],
        [f"<results>/figures/{name}.svg" for name in figure_names(SCENES) if name.startswith("cost_")],
    message:
        "what accuracy costs in time: tables cost_full_order, cost_reduced, cheapest and break_even, figures cost_*"
