# What each effect of a scene is worth: each is left out in turn. No reduced model takes part.


rule full_order_effects:
    input:
        structure=rules.structure.output.structure,
        release=rules.release.output.release,
    output:
        output="<results>/{scene}/full_order/effects.nc",
    log:
        "<logs>/{scene}/full_order/effects.log",
    benchmark:
        "<benchmarks>/{scene}/full_order/effects.tsv"
    priority: 40
    threads: 1
    params:
        scene=scene_part("experiments", "time"),
        lengths=SETTINGS.studies["ablation"],
        provenance=full_order_code("full_order_effects"),
    message:
        "{wildcards.scene}: full order, each effect left out in turn"
    script:
        "../scripts/step.py"
