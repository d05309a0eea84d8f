# The grid of hard cases: one job a fitted model and one for the full order of each scene.

ROBUSTNESS = SETTINGS.studies.get("robustness", {"scenes": []})
STABILITY = {
    key: value for key, value in ROBUSTNESS.items() if key not in ("scenes", "full_order")
}


def model_stability_code(wildcards):
    """The code of the grid, of the scene's effects, whose energy is asked for, and of the model."""
    return code(
        "stability",
        *scene_modules(wildcards),
        *model_modules(wildcards),
    )


rule model_stability:
    input:
        structure=rules.structure.output.structure,
        train="<results>/{scene}/full_order/train.nc",
        test="<results>/{scene}/full_order/test.nc",
        forced_run=rules.full_order_forced.output.output,
        curve=rules.full_order_frc.output.output,
        rom="<results>/{scene}/{method}/{seed}/rom.nc",
    output:
        output="<results>/{scene}/{method}/{seed}/stability.nc",
    log:
        "<logs>/{scene}/{method}/{seed}/stability.log",
    benchmark:
        "<benchmarks>/{scene}/{method}/{seed}/stability.tsv"
    params:
        step="stability",
        scene=scene_part("experiments", "time"),
        scene_name="{scene}",
        method="{method}",
        seed=seed_of,
        stability=STABILITY,
        provenance=model_stability_code,
    message:
        "{wildcards.scene}: {wildcards.method} {wildcards.seed}: hard cases"
    script:
        "../scripts/step.py"


rule full_order_stability:
    input:
        structure=rules.structure.output.structure,
        curve=rules.full_order_frc.output.output,
    output:
        stability="<results>/{scene}/full_order/stability.nc",
    log:
        "<logs>/{scene}/full_order/stability.log",
    benchmark:
        "<benchmarks>/{scene}/full_order/stability.tsv"
    params:
        scene=scene_part("experiments", "time"),
        settings=ROBUSTNESS.get("full_order"),
        provenance=full_order_code("full_order_stability"),
    message:
        "{wildcards.scene}: full order: coarse steps"
    script:
        "../scripts/step.py"
