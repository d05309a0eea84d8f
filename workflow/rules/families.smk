# Tables and figures, each family from its own artefacts: what the models are asked, what accuracy costs, what effects are worth, hard cases.
#
#   snakemake --cores 2 tables          all of them (or: figures)
#   snakemake --cores 2 cost            one family (or: effects, stability)
OF_FULL_ORDER = [
    f"<results>/{scene}/{settings.FULL_ORDER}/{name}.nc"
    for scene in COST_SCENES
    for name in FULL_ORDER_NAMES
]
OF_METHODS = [
    f"<results>/{'/'.join(model)}/rom.nc" for model in MODELS if model[0] in COST_SCENES
]  # which gives them their looks
FILES = {
    "models": list(
        dict.fromkeys(ARTEFACTS + HARD_FILES)
    ),  # what guards promise is among the checks
    "cost": COST_ARTEFACTS + OF_FULL_ORDER + OF_METHODS,
    "effects": EFFECTS_FILES,
    "stability": HARD_FILES,
}

for FAMILY in FILES:
    SCORES = {"scores": rules.scores.output.scores} if FAMILY == "models" else {}

    rule:
        name:
            f"{FAMILY}_tables"
        input:
            **SCORES,
            artefacts=FILES[FAMILY],
        output:
            tables=in_report(table_files(FAMILY)),
        log:
            f"<logs>/{FAMILY}_tables.log",
        params:
            step="tables",
            provenance=code("tables"),
        message:
            f"tables of {FAMILY}"
        script:
            "../scripts/step.py"

    rule:
        name:
            f"{FAMILY}_figures"
        input:
            **SCORES,
            artefacts=FILES[FAMILY],
        output:
            figures=in_report(figure_files(FAMILY)),
        log:
            f"<logs>/{FAMILY}_figures.log",
        benchmark:
            f"<benchmarks>/{FAMILY}_figures.tsv"
        params:
            step="figures",
            provenance=code("figures"),
        message:
            f"figures of {FAMILY}"
        script:
            "../scripts/step.py"


for TARGET, PATHS in {
    "tables": table_files(),
    "figures": figure_files(),
    **{
        FAMILY: table_files(FAMILY) + figure_files(FAMILY)
        for FAMILY in ("cost", "effects", "stability")
    },
}.items():

    rule:
        name:
            TARGET
        input:
            PATHS,
        localrule: True
        message:
            f"{TARGET}: everything is there"
