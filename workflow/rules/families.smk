# Tables and figures of what is asked beside the reduced models, each family from its own artefacts and under its own name:
#
#   snakemake --cores 2 effects
#   snakemake --cores 2 stability

for FAMILY, FILES in {"effects": EFFECTS_FILES, "stability": HARD_FILES}.items():

    rule:
        name:
            f"{FAMILY}_tables"
        input:
            artefacts=FILES,
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
            artefacts=FILES,
        output:
            figures=in_report(figure_files(FAMILY)),
        log:
            f"<logs>/{FAMILY}_figures.log",
        params:
            step="figures",
            provenance=code("figures"),
        message:
            f"figures of {FAMILY}"
        script:
            "../scripts/step.py"

    rule:
        name:
            FAMILY
        localrule: True
        input:
            table_files(FAMILY),
            figure_files(FAMILY),
        message:
            f"tables and figures of {FAMILY}: everything is there"
