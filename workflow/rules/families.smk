# Tables and figures, each family from its own artefacts.
#
#   snakemake --cores 2 tables          all of them (or: figures)
#   snakemake --cores 2 cost            one family (or: ablation, robustness)


for FAMILY in PRESENT:
    for KIND in MADE:
        if not MADE[KIND][FAMILY]:
            continue

        rule:
            name:
                f"{FAMILY}_{KIND}"
            input:
                artefacts=FAMILIES[FAMILY].artefacts,
            output:
                outputs=in_report(KIND, FAMILY),
            log:
                f"<logs>/{FAMILY}_{KIND}.log",
            benchmark:
                f"<benchmarks>/{FAMILY}_{KIND}.tsv"
            conda:
                "../../envs/vibrom.yaml"
            params:
                step="output",
                kind=KIND,
                provenance=code("output", f"report.{KIND}", *modules(KIND, [FAMILY])),
            message:
                f"{KIND} of {FAMILY}"
            script:
                "../scripts/step.py"


for TARGET, PATHS in {
    "tables": files("tables"),
    "figures": files("figures"),
    **{
        FAMILY: files("tables", [FAMILY]) + files("figures", [FAMILY])
        for FAMILY in PRESENT
        if FAMILY != "models"
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
