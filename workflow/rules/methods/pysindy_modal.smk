# An outside method: a peer's package, called by a script that reads and writes the artefacts with
# xarray alone. The rule writes rom.nc and losses.nc like any other fit, and its models take part in
# every experiment and table.
PYSINDY = METHODS["pysindy_modal"]
PYSINDY_SCRIPT = Path(workflow.source_path("../../scripts/fit_pysindy_modal.py"))
PYSINDY_SETTINGS = ["modes", "degree", "threshold"]

for KEY, VALUE in PYSINDY["settings"].items():
    if KEY not in PYSINDY_SETTINGS:
        CURE = f"is no setting of pysindy_modal; {errors.closest(KEY, PYSINDY_SETTINGS)}"
        sys.exit(f"vibrom: config/methods/pysindy_modal.yaml: settings.{KEY} = {VALUE!r} {CURE}")


rule fit_pysindy_modal:
    input:
        structure=rules.structure.output.structure,
        train="<results>/{scene}/full_order/train.nc",
    output:
        rom="<results>/{scene}/pysindy_modal/{seed}/rom.nc",
        losses="<results>/{scene}/pysindy_modal/{seed}/losses.nc",
    log:
        "<logs>/{scene}/pysindy_modal/{seed}/fit.log",
    benchmark:
        "<benchmarks>/{scene}/pysindy_modal/{seed}/fit.tsv"
    priority: 50
    conda:
        "../../../envs/vibrom.yaml"
    resources:
        mem_mb=memory("whole"),  # it reads the decay so
    params:
        scene_name="{scene}",
        settings=PYSINDY["settings"],
        rom_class=PYSINDY["rom_class"],
        provenance=provenance.script_attributes(PYSINDY_SCRIPT, ("pysindy", "numpy", "sklearn")),
    message:
        "{wildcards.scene}: pysindy_modal {wildcards.seed}: fit"
    script:
        "../../scripts/fit_pysindy_modal.py"
