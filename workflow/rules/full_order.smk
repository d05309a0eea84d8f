# The full-order model of each scene: structure, release states, the two decays, the forced run and the response curve.
# The sweep is the longest job: it starts as soon as its structure is there, and everything else runs beside it.


def scene_part(*keys):
    """The blocks of the scene that a rule reads; a change in another block does not run it again."""
    return lambda wildcards: {
        key: SCENES[wildcards.scene][key] for key in ("body", "effects", *keys)
    }


def full_order_code(step):
    return lambda wildcards: code(
        step, *(f"effects.{effect}" for effect in SCENES[wildcards.scene]["effects"])
    )


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


rule full_order_decay:
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
        scene=scene_part("decay", "time"),
        role="{role}",
        provenance=full_order_code("full_order_decay"),
    message:
        "{wildcards.scene}: full-order decay ({wildcards.role})"
    script:
        "../scripts/step.py"


rule full_order_forced:
    input:
        structure=rules.structure.output.structure,
    output:
        forced="<results>/{scene}/full_order/forced.nc",
    log:
        "<logs>/{scene}/full_order/forced.log",
    benchmark:
        "<benchmarks>/{scene}/full_order/forced.tsv"
    priority: 60
    params:
        scene=scene_part("forced", "time"),
        provenance=full_order_code("full_order_forced"),
    message:
        "{wildcards.scene}: full-order forced run"
    script:
        "../scripts/step.py"


rule full_order_frc:
    input:
        structure=rules.structure.output.structure,
    output:
        frc="<results>/{scene}/full_order/frc.nc",
    log:
        "<logs>/{scene}/full_order/frc.log",
    benchmark:
        "<benchmarks>/{scene}/full_order/frc.tsv"
    priority: 90
    threads: 1
    params:
        scene=scene_part("frc", "time"),
        provenance=full_order_code("full_order_frc"),
    message:
        "{wildcards.scene}: full-order response curve"
    script:
        "../scripts/step.py"
