# One rule an experiment for the fitted models, and one more where the full-order model is asked the same.
# What an experiment reads is said by the constants of its file in src/vibrom/experiments.

EXPERIMENTS = {name: constants("experiments", name) for name in names("experiments")}
FULL_ORDER_NAMES = ("structure", "release", "train", "test", "forced", "frc")


def artefacts(experiment, needs, model):
    """The inputs of an experiment by name; `model` is the folder of the model that is asked.

    The name of another experiment is that answer of the same model. All else that the full-order model has comes from
    there, and so does the experiment's own name: what its answer is compared with."""
    inputs = {}
    for need in needs:
        if need in ("rom", "losses") or (need in EXPERIMENTS and need != experiment):
            inputs[need] = f"<results>/{{scene}}/{model}/{need}.nc"
        elif need in FULL_ORDER_NAMES:
            inputs[need] = f"<results>/{{scene}}/{settings.FULL_ORDER}/{need}.nc"
        else:
            known = ", ".join((*FULL_ORDER_NAMES, "rom", "losses", *EXPERIMENTS))
            sys.exit(
                f"vibrom: experiments/{experiment}.py: needs {need!r}, which no rule makes; choose from {known}"
            )
    return inputs


def model_modules(wildcards):
    """The modules of the model that is asked; none for the full order."""
    method = getattr(wildcards, "method", None)
    outside = METHODS[method].get("rom_class") if method else None
    return (
        [outside.split(":")[0].removeprefix("vibrom.")]
        if outside
        else [f"methods.{SETTINGS.kind_of(method)}"] if method else []
    )


def experiment_code(experiment):
    """The code of the experiment and of the model that it asks."""
    return lambda wildcards: code(
        "experiment", f"experiments.{experiment}", *model_modules(wildcards)
    )


for EXPERIMENT, CONSTANTS in EXPERIMENTS.items():

    rule:
        name:
            EXPERIMENT
        input:
            **artefacts(EXPERIMENT, CONSTANTS["needs"], "{method}/{seed}"),
        output:
            output=f"<results>/{{scene}}/{{method}}/{{seed}}/{EXPERIMENT}.nc",
        log:
            f"<logs>/{{scene}}/{{method}}/{{seed}}/{EXPERIMENT}.log",
        benchmark:
            f"<benchmarks>/{{scene}}/{{method}}/{{seed}}/{EXPERIMENT}.tsv"
        params:
            step="experiment",
            experiment=EXPERIMENT,
            scene_name="{scene}",
            method="{method}",
            seed=seed_of,
            integrator=SETTINGS.integrator,
            provenance=experiment_code(EXPERIMENT),
        message:
            f"{{wildcards.scene}}: {{wildcards.method}} {{wildcards.seed}}: {EXPERIMENT}"
        script:
            "../scripts/step.py"

    if CONSTANTS.get("full_order") is None:
        continue

    rule:
        name:
            f"full_order_{EXPERIMENT}"
        input:
            **artefacts(EXPERIMENT, CONSTANTS["full_order"], settings.FULL_ORDER),
        output:
            output=f"<results>/{{scene}}/full_order/{EXPERIMENT}.nc",
        log:
            f"<logs>/{{scene}}/full_order/{EXPERIMENT}.log",
        benchmark:
            f"<benchmarks>/{{scene}}/full_order/{EXPERIMENT}.tsv"
        params:
            step="experiment",
            experiment=EXPERIMENT,
            scene_name="{scene}",
            method=settings.FULL_ORDER,
            seed=None,
            integrator=SETTINGS.integrator,
            provenance=experiment_code(EXPERIMENT),
        message:
            f"{{wildcards.scene}}: full_order: {EXPERIMENT}"
        script:
            "../scripts/step.py"
