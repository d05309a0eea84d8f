# One rule a method, made from the configuration: fit_split, fit_ssmlearn, ...; variants of a method
# (ssmlearn_11) have rules of their own. A method whose block names a rule file brings its own rule
# instead; that rule writes the same rom.nc and losses.nc.


include: "planning/methods.smk"


for METHOD, BLOCK in METHODS.items():
    if "rule" in BLOCK:

        include: rules_of_tool(BLOCK["rule"])

        continue

    rule:
        name:
            f"fit_{METHOD}"
        input:
            unpack(fitted_once(METHOD).inputs),
            unpack(start_input(METHOD)),
            **learnt_from(METHOD),
            structure=rules.structure.output.structure,
        output:
            rom=f"<results>/{{scene}}/{METHOD}/{{seed}}/rom.nc",
            losses=f"<results>/{{scene}}/{METHOD}/{{seed}}/losses.nc",
        log:
            f"<logs>/{{scene}}/{METHOD}/{{seed}}/fit.log",
        benchmark:
            f"<benchmarks>/{{scene}}/{METHOD}/{{seed}}/fit.tsv"
        priority: 50
        conda:
            "../../envs/vibrom.yaml"
        threads: BLOCK.get("resources", {}).get("threads", 1)
        resources:
            **resources(METHOD),
        params:
            **equations_of(METHOD),
            step=fitted_once(METHOD).step,
            recipe=recipe(METHOD),
            checkpoint=checkpoint(METHOD),
            provenance=fit_code(METHOD),
        message:
            f"{{wildcards.scene}}: {METHOD} {{wildcards.seed}}: fit"
        script:
            "../scripts/step.py"
