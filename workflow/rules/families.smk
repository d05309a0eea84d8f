# Tables and figures, each family from its own artefacts; the figures of a scene as soon as that
# scene is through.
#
#   snakemake --cores 2 tables          all of them (or: figures)
#   snakemake --cores 2 cost            one family (or: ablation, robustness)

for PART in parts():
    FAMILY, KIND = PART.family, PART.kind

    rule:
        name:
            PART.name
        input:
            **scored(PART),
            artefacts=made_from(PART),
        output:
            outputs=in_report(PART),
        log:
            f"<logs>/{PART.folder}{FAMILY}_{KIND}.log",
        benchmark:
            f"<benchmarks>/{PART.folder}{FAMILY}_{KIND}.tsv"
        wildcard_constraints:
            scene="|".join(map(re.escape, PART.scenes)),
        conda:
            "../../envs/vibrom.yaml"
        resources:
            mem_mb=memory("sink"),
        params:
            step="output",
            kind=KIND,
            not_asked=not_asked(PART),
            provenance=code("output", f"report.{KIND}", *modules(KIND, [FAMILY])),
        message:
            f"{KIND} of {FAMILY}{', {wildcards.scene}' if PART.folder else ''}"
        script:
            "../scripts/step.py"


for TARGET, PATHS in {
    "tables": files("tables"),
    "figures": files("figures"),
    **{
        FAMILY: files("tables", [FAMILY]) + files("figures", [FAMILY])
        for FAMILY in PRESENT
        if FAMILY not in ("models", "ablation")
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


if "ablation" in PRESENT:

    rule:
        # It has no output: who asks for it is told what the study found, also where all is there.
        name:
            "ablation"
        input:
            artefacts=of_study("ablation"),
            shown=files("tables", ["ablation"]) + files("figures", ["ablation"]),
        log:
            "<logs>/advice.log",
        conda:
            "../../envs/vibrom.yaml"
        resources:
            mem_mb=memory("sink"),
        params:
            step="advice",
        message:
            "which effects the scenes need"
        script:
            "../scripts/step.py"
