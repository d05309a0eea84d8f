# What accuracy costs in time: settings of the full-order model and of the methods, one job a scene for each.
# What is studied is said by `cost` in the configuration.
COST = SETTINGS.studies.get("cost", {"scenes": [], "reduced": {}})
COST_SCENES = [scene for scene in COST["scenes"] if scene in SCENES]
COST_ARTEFACTS = [
    f"<results>/{scene}/{settings.FULL_ORDER}/cost_{what}.nc"
    for scene in COST_SCENES
    for what in ("full_order", "reduced")
]


def models_of(wildcards):
    """Every fitted model of the scene."""
    return [
        f"<results>/{wildcards.scene}/{method}/{seed}/rom.nc"
        for method in METHODS
        for seed in SETTINGS.seed_folders(method)
    ]


def studied_methods():
    """What the study needs to fit a method with other settings: of those that it varies, and of those that they start from."""
    return {
        method: {
            "kind": SETTINGS.kind_of(method),
            "settings": block["settings"],
            "seeded": block["seeded"],
            "start": block.get("starts_from"),
        }
        for method, block in METHODS.items()
        if "rule" not in block or method in COST["reduced"]
    }


def model_code():
    """The modules behind every model of the run."""
    outside = [
        block["rom_class"].split(":")[0].removeprefix("vibrom.")
        for block in METHODS.values()
        if "rule" in block
    ]
    return sorted(
        {
            *outside,
            *(
                f"methods.{SETTINGS.kind_of(method)}"
                for method, block in METHODS.items()
                if "rule" not in block
            ),
        }
    )


rule cost_full_order:
    input:
        structure=rules.structure.output.structure,
        release=rules.release.output.release,
    output:
        cost="<results>/{scene}/full_order/cost_full_order.nc",
    log:
        "<logs>/{scene}/full_order/cost_full_order.log",
    benchmark:
        "<benchmarks>/{scene}/full_order/cost_full_order.tsv"
    priority: 55
    threads: 1
    params:
        scene=scene_part("record", "experiments", "time"),
        settings=COST.get("full_order"),
        repeats=COST.get("repeats"),
        patience=COST.get("patience"),
        provenance=full_order_code("cost_full_order"),
    message:
        "{wildcards.scene}: what the accuracy of the full-order model costs"
    script:
        "../scripts/step.py"


rule cost_reduced:
    input:
        **{
            name: f"<results>/{{scene}}/{settings.FULL_ORDER}/{name}.nc"
            for name in ("structure", "train", "test", "forced", "frc")
        },
        models=models_of,
    output:
        cost="<results>/{scene}/full_order/cost_reduced.nc",
    log:
        "<logs>/{scene}/full_order/cost_reduced.log",
    benchmark:
        "<benchmarks>/{scene}/full_order/cost_reduced.tsv"
    priority: 45
    threads: 1
    params:
        scene_name="{scene}",
        methods=studied_methods(),
        settings=COST["reduced"],
        seed=SETTINGS.seeds[0],
        device=SETTINGS.device,
        integrator=SETTINGS.integrator,
        repeats=COST.get("repeats"),
        patience=COST.get("patience"),
        provenance=code(
            "cost_reduced",
            *(f"experiments.{name}" for name in ("decay", "forced", "frc")),
            *model_code(),
        ),
    message:
        "{wildcards.scene}: what the accuracy of the reduced models costs"
    script:
        "../scripts/step.py"
