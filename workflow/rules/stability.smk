# The grid of hard cases: one job a fitted model and one for the full order of each scene.

STABILITY = {
    key: value for key, value in SETTINGS.stability.items() if key not in ("scenes", "full_order")
}


def model_stability_code(wildcards):
    """The code of the grid, of the scene's effects, whose energy is asked for, and of the model."""
    return code(
        "stability",
        *(f"effects.{effect}" for effect in SCENES[wildcards.scene]["effects"]),
        *model_modules(wildcards),
    )


rule model_stability:
    input:
        structure=rules.structure.output.structure,
        train="<results>/{scene}/full_order/train.nc",
        test="<results>/{scene}/full_order/test.nc",
        forced_run=rules.full_order_forced.output.forced,
        curve=rules.full_order_frc.output.frc,
        rom="<results>/{scene}/{method}/{seed}/rom.nc",
    output:
        output="<results>/{scene}/{method}/{seed}/stability.nc",
    log:
        "<logs>/{scene}/{method}/{seed}/stability.log",
    benchmark:
        "<benchmarks>/{scene}/{method}/{seed}/stability.tsv"
    params:
        step="stability",
        scene=scene_part("frc", "time"),
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
        curve=rules.full_order_frc.output.frc,
    output:
        stability="<results>/{scene}/full_order/stability.nc",
    log:
        "<logs>/{scene}/full_order/stability.log",
    benchmark:
        "<benchmarks>/{scene}/full_order/stability.tsv"
    params:
        scene=scene_part("frc", "time"),
        settings=SETTINGS.stability.get("full_order"),
        provenance=full_order_code("full_order_stability"),
    message:
        "{wildcards.scene}: full order: coarse steps"
    script:
        "../scripts/step.py"
