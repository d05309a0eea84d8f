# One rule an experiment for the fitted models, and one more where the full-order model is evaluated
# too. What an experiment reads is said by the constants of its class in src/vibrom/experiments.


include: "planning/experiments.smk"


# Of the full order: the longest first.
PRIORITY = {"sweeps": 96, "branches": 94, "frc": 90, "forced": 60}

for EXPERIMENT, CONSTANTS in EXPERIMENTS.items():

    rule:
        name:
            EXPERIMENT
        input:
            **reads(EXPERIMENT, "{method}/{seed}"),
            **truth(EXPERIMENT),
            structure=rules.structure.output.structure,
            rom="<results>/{scene}/{method}/{seed}/rom.nc",
        output:
            output=f"<results>/{{scene}}/{{method}}/{{seed}}/{EXPERIMENT}.nc",
        log:
            f"<logs>/{{scene}}/{{method}}/{{seed}}/{EXPERIMENT}.log",
        benchmark:
            f"<benchmarks>/{{scene}}/{{method}}/{{seed}}/{EXPERIMENT}.tsv"
        conda:
            "../../envs/vibrom.yaml"
        params:
            step="ask",
            name=EXPERIMENT,
            settings=asked(EXPERIMENT),
            names=lambda wildcards: {
                "scene": wildcards.scene,
                "method": wildcards.method,
                "seed": seed_of(wildcards),
            },
            samples=samples,
            integrator=SETTINGS.integrator,
            provenance=reduced_code(EXPERIMENT),
        message:
            f"{{wildcards.scene}}: {{wildcards.method}} {{wildcards.seed}}: {EXPERIMENT}"
        script:
            "../scripts/step.py"

    if not CONSTANTS["of_full_order"]:
        continue

    rule:
        name:
            f"full_order_{EXPERIMENT}"
        input:
            **reads(EXPERIMENT, settings.FULL_ORDER),
            structure=rules.structure.output.structure,
        output:
            output=f"<results>/{{scene}}/full_order/{EXPERIMENT}.nc",
        log:
            f"<logs>/{{scene}}/full_order/{EXPERIMENT}.log",
        benchmark:
            f"<benchmarks>/{{scene}}/full_order/{EXPERIMENT}.tsv"
        priority: PRIORITY.get(EXPERIMENT, 0)
        conda:
            "../../envs/vibrom.yaml"
        params:
            step="ask",
            name=EXPERIMENT,
            settings=asked(EXPERIMENT),
            names=lambda wildcards: {
                "scene": wildcards.scene,
                "method": settings.FULL_ORDER,
                "seed": None,
            },
            samples=samples,
            scene=scene_part("time"),
            provenance=full_order_answer_code(EXPERIMENT),
        message:
            f"{{wildcards.scene}}: full order: {EXPERIMENT}"
        script:
            "../scripts/step.py"
