# Experiments on the fitted models, short ones together in one job, and one rule more for each where
# the full-order model is evaluated too. What an experiment reads is said by the constants of its
# class in src/vibrom/experiments.


include: "planning/experiments.smk"


# Of the full order: the longest first, but branches after sweeps, whose kernels they need, too:
# beside one another both would compile them.
PRIORITY = {"sweeps": 96, "frc": 94, "branches": 90, "forced": 60}

for JOB, MEMBERS, WHERE in JOBS:

    rule:
        name:
            JOB
        input:
            **reads(MEMBERS, "{method}/{seed}"),
            **truths(MEMBERS),
            structure=rules.structure.output.structure,
            rom="<results>/{scene}/{method}/{seed}/rom.nc",
        output:
            **{name: f"<results>/{{scene}}/{{method}}/{{seed}}/{name}.nc" for name in MEMBERS},
        log:
            f"<logs>/{{scene}}/{{method}}/{{seed}}/{JOB}.log",
        benchmark:
            f"<benchmarks>/{{scene}}/{{method}}/{{seed}}/{JOB}.tsv"
        wildcard_constraints:
            scene="|".join(map(re.escape, WHERE)),
        priority: waited_for(MEMBERS)
        conda:
            "../../envs/vibrom.yaml"
        resources:
            mem_mb=memory("answer"),
        params:
            step="ask",
            questions=asked(MEMBERS),
            names=lambda wildcards: {
                "scene": wildcards.scene,
                "method": wildcards.method,
                "seed": seed_of(wildcards),
            },
            samples=samples,
            integrator=SETTINGS.integrator,
            provenance=reduced_code(MEMBERS),
        message:
            f"{{wildcards.scene}}: {{wildcards.method}} {{wildcards.seed}}: {JOB}"
        script:
            "../scripts/step.py"


for EXPERIMENT, CONSTANTS in EXPERIMENTS.items():
    if not CONSTANTS["of_full_order"]:
        continue

    rule:
        name:
            f"full_order_{EXPERIMENT}"
        input:
            unpack(answered_once(EXPERIMENT).inputs),
            **reads([EXPERIMENT], settings.FULL_ORDER),
            structure=rules.structure.output.structure,
        output:
            **{EXPERIMENT: f"<results>/{{scene}}/full_order/{EXPERIMENT}.nc"},
        log:
            f"<logs>/{{scene}}/full_order/{EXPERIMENT}.log",
        benchmark:
            f"<benchmarks>/{{scene}}/full_order/{EXPERIMENT}.tsv"
        priority: PRIORITY.get(EXPERIMENT, 0)
        conda:
            "../../envs/vibrom.yaml"
        resources:
            mem_mb=memory("full_order_answer"),
        params:
            step=answered_once(EXPERIMENT).step,
            questions=asked([EXPERIMENT]),
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
