# Tables and figures, each family from its own artefacts; the figures of a scene as soon as that
# scene is through.
#
#   snakemake --cores 2 tables          all of them (or: figures)
#   snakemake --cores 2 cost            one family (or: ablation, robustness)
from itertools import product

for FAMILY, KIND, EACH in product(PRESENT, MADE, ("run", "scene")):
    OUTPUTS = in_report(KIND, FAMILY, EACH)
    if not OUTPUTS:
        continue

    rule:
        name:
            f"{FAMILY}_{KIND}" if EACH == "run" else f"{FAMILY}_{KIND}_of_scene"
        input:
            artefacts=made_from(FAMILY, EACH),
        output:
            outputs=OUTPUTS,
        log:
            f"<logs>/{'' if EACH == 'run' else '{scene}/'}{FAMILY}_{KIND}.log",
        benchmark:
            f"<benchmarks>/{'' if EACH == 'run' else '{scene}/'}{FAMILY}_{KIND}.tsv"
        conda:
            "../../envs/vibrom.yaml"
        params:
            step="output",
            kind=KIND,
            provenance=code("output", f"report.{KIND}", *modules(KIND, [FAMILY])),
        message:
            f"{KIND} of {FAMILY}{'' if EACH == 'run' else ', {wildcards.scene}'}"
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
