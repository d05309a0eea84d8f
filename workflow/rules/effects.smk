# What each effect of a scene is worth: each is left out in turn. No reduced model takes part, so that the table and the figures have rules of their own.
#
#   snakemake --cores 2 effects


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
    params:
        scene=scene_part("forced", "time"),
        lengths=SETTINGS.effects,
        provenance=full_order_code("full_order_effects"),
    threads: 1
    priority: 40
    message:
        "{wildcards.scene}: full order, each effect left out in turn"
    script:
        "../scripts/step.py"


rule effects_tables:
    input:
        artefacts=EFFECTS_FILES,
    output:
        tables=table_files("effects"),
    log:
        "<logs>/effects_tables.log",
    params:
        step="tables",
        provenance=code("tables"),
    message:
        "tables of effects"
    script:
        "../scripts/step.py"


rule effects_figures:
    input:
        artefacts=EFFECTS_FILES,
    output:
        figures=figure_files("effects"),
    log:
        "<logs>/effects_figures.log",
    params:
        step="figures",
        provenance=code("figures"),
    message:
        "figures of effects"
    script:
        "../scripts/step.py"


rule effects:
    localrule: True
    input:
        rules.effects_tables.output,
        rules.effects_figures.output,
    message:
        "the table and figures of effects are there"
