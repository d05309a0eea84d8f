# What the full-order model of a scene brings before anything is asked: structure, release states and
# the two recorded decays.


def scene_part(*keys):
    """The blocks of the scene that a rule reads; a change in another block does not run it again."""
    return lambda wildcards: {
        key: SCENES[wildcards.scene][key] for key in ("body", "effects", *keys)
    }


def scene_modules(wildcards):
    """The modules of the scene's body and effects."""
    return SETTINGS.modules_of(wildcards.scene)


def full_order_code(step):
    """The code of a step that builds the full-order model, and of the scene's effects."""
    return lambda wildcards: code(step, *scene_modules(wildcards))


rule structure:
    output:
        structure="<results>/{scene}/full_order/structure.nc",
    log:
        "<logs>/{scene}/full_order/structure.log",
    benchmark:
        "<benchmarks>/{scene}/full_order/structure.tsv"
    priority: 100
    params:
        scene=scene_part(),
        name="{scene}",
        provenance=full_order_code("structure"),
    message:
        "{wildcards.scene}: structure"
    script:
        "../scripts/step.py"


rule release:
    input:
        structure=rules.structure.output.structure,
    output:
        release="<results>/{scene}/full_order/release.nc",
    log:
        "<logs>/{scene}/full_order/release.log",
    benchmark:
        "<benchmarks>/{scene}/full_order/release.tsv"
    priority: 80
    params:
        scene=scene_part("releases", "time"),
        provenance=full_order_code("release"),
    message:
        "{wildcards.scene}: release states"
    script:
        "../scripts/step.py"


rule record:
    input:
        structure=rules.structure.output.structure,
        release=rules.release.output.release,
    output:
        trajectory="<results>/{scene}/full_order/{role}.nc",
    log:
        "<logs>/{scene}/full_order/{role}.log",
    benchmark:
        "<benchmarks>/{scene}/full_order/{role}.tsv"
    priority: 70
    params:
        scene=scene_part("record", "time"),
        role="{role}",
        provenance=full_order_code("record"),
    message:
        "{wildcards.scene}: recorded decay ({wildcards.role})"
    script:
        "../scripts/step.py"
