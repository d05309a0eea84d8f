# What a recorded scene brings before anything is asked: the artefacts that the full-order model of
# other scenes makes, from files of recorded motion.


rule recorded:
    input:
        unpack(make_again),
        files=recorded_files,
    output:
        structure="<results>/{scene}/full_order/structure.nc",
        train="<results>/{scene}/full_order/train.nc",
        test="<results>/{scene}/full_order/test.nc",
    log:
        "<logs>/{scene}/full_order/recorded.log",
    benchmark:
        "<benchmarks>/{scene}/full_order/recorded.tsv"
    wildcard_constraints:
        scene=among(RECORDED_SCENES),
    priority: 100
    conda:
        "../../envs/vibrom.yaml"
    resources:
        mem_mb=memory("whole"),
    params:
        step="recorded",
        scene=lambda wildcards: SCENES[wildcards.scene],
        provenance=code("recorded"),
    message:
        "{wildcards.scene}: recorded motion"
    script:
        "../scripts/step.py"
