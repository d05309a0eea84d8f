# What the full-order model of a scene brings before anything is asked: structure, release states
# and the two recorded decays.


rule structure:
    input:
        unpack(make_again),
    output:
        structure="<results>/{scene}/full_order/structure.nc",
    log:
        "<logs>/{scene}/full_order/structure.log",
    benchmark:
        "<benchmarks>/{scene}/full_order/structure.tsv"
    wildcard_constraints:
        scene=among(WITH_BODY),
    priority: 100
    conda:
        "../../envs/vibrom.yaml"
    resources:
        mem_mb=memory("full_order"),
    params:
        step="structure",
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
    wildcard_constraints:
        scene=among(WITH_BODY),
    priority: 80
    conda:
        "../../envs/vibrom.yaml"
    resources:
        mem_mb=memory("full_order"),
    params:
        step="release",
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
    wildcard_constraints:
        scene=among(WITH_BODY),
    priority: 70
    conda:
        "../../envs/vibrom.yaml"
    resources:
        mem_mb=memory("full_order"),
    params:
        step="record",
        scene=scene_part("record", "time"),
        role="{role}",
        provenance=full_order_code("record"),
    message:
        "{wildcards.scene}: recorded decay ({wildcards.role})"
    script:
        "../scripts/step.py"
