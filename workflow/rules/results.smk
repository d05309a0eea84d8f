# From the artefacts of all models to scores, the report and MLflow. Tables and figures are files in
# src/vibrom/report/tables and figures; their constants say what the workflow must know.


include: "planning/results.smk"


rule scores:
    input:
        predictions=SCORED,
    output:
        scores="<results>/scores.csv",
        digest="<results>/scores.csv.digest",
    log:
        "<logs>/scores.log",
    conda:
        "../../envs/vibrom.yaml"
    resources:
        mem_mb=memory("sink"),
    params:
        step="scores",
        provenance=code("scores"),
    message:
        "scores of all models"
    script:
        "../scripts/step.py"


rule report:
    input:
        artefacts=all_artefacts(),
        scores=rules.scores.output.scores,
        figures=files("figures", forms=("svg", "png")),
    output:
        report="<results>/report.html",
    log:
        "<logs>/report.log",
    conda:
        "../../envs/vibrom.yaml"
    resources:
        mem_mb=memory("sink"),
    params:
        step="report",
        tables_shown=plugs_shown("tables"),
        captions=outputs.captions({kind: plugs_shown(kind) for kind in MADE}, SCENES),
        provenance=code("report", *modules("tables"), *modules("figures")),
    message:
        "report"
    script:
        "../scripts/step.py"


rule tracking:
    input:
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
    conda:
        "../../envs/vibrom.yaml"
    resources:
        mem_mb=memory("sink"),
    params:
        step="tracking",
        artefacts=behind(FITTED + SCORED + of_full_order(SCENES, ["structure"])),
        provenance=code("tracking"),
    message:
        "MLflow store"
    script:
        "../scripts/step.py"


rule crate:
    input:
        shown=[
            *files("tables", forms=["csv"]),
            *files("figures", forms=["pdf"]),
            rules.scores.output.scores,
            rules.report.output.report,
        ],
    output:
        crate="<results>/ro-crate-metadata.json",
    log:
        "<logs>/crate.log",
    conda:
        "../../envs/vibrom.yaml"
    resources:
        mem_mb=memory("sink"),
    params:
        step="crate",
        artefacts=behind(all_artefacts()),
        provenance=code("crate"),
    message:
        "what was made from what"
    script:
        "../scripts/step.py"


rule headline:
    input:
        report=rules.report.output.report,
        scores=rules.scores.output.scores,
        # Last of all: what it prints is the end of the run.
        store=rules.tracking.output.store,
        crate=rules.crate.output.crate,
    output:
        headline="<results>/headline.txt",
    log:
        "<logs>/headline.log",
    conda:
        "../../envs/vibrom.yaml"
    resources:
        mem_mb=memory("sink"),
    params:
        step="headline",
        artefacts=behind(FAMILIES["models"].artefacts),
        provenance=code("headline", *modules("tables", ["models"])),
    message:
        "headline numbers"
    script:
        "../scripts/step.py"
