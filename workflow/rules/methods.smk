# One rule a method, made from the configuration: fit_split, fit_ssmlearn, ...; variants of a method (ssmlearn_11) have rules of their own.
# A method whose block names a rule file brings its own rule instead; that rule writes the same rom.nc and losses.nc.
import hashlib


def start_input(method):
    """The fitted model that a method starts from, as its input `start`."""

    def inputs(wildcards):
        start = SETTINGS.start_of(method, wildcards.seed)
        return (
            {}
            if start is None
            else {"start": f"<results>/{wildcards.scene}/{start[0]}/{start[1]}/rom.nc"}
        )

    return inputs


def checkpoint(method):
    """Where an interrupted training resumes; another scene, setting or code starts again, in its own file."""

    def path(wildcards, output):
        recipe = (
            SCENES[wildcards.scene],
            METHODS[method],
            code("fit", f"methods.{SETTINGS.kind_of(method)}"),
        )
        key = hashlib.sha256(repr(recipe).encode()).hexdigest()[:8]
        return str(Path(output.rom).with_name(f"checkpoint_{key}.npz"))

    return path


def recipe(method):
    """Which method learns what, and how."""

    def fields(wildcards):
        return {
            "scene": wildcards.scene,
            "method": method,
            "kind": SETTINGS.kind_of(method),
            "settings": METHODS[method]["settings"],
            "seed": seed_of(wildcards),
            "device": SETTINGS.device,
        }

    return fields


for METHOD, BLOCK in METHODS.items():
    if "rule" in BLOCK:

        include: ROOT / BLOCK["rule"]

        continue

    rule:
        name:
            f"fit_{METHOD}"
        input:
            unpack(start_input(METHOD)),
            structure=rules.structure.output.structure,
            train="<results>/{scene}/full_order/train.nc",
        output:
            rom=f"<results>/{{scene}}/{METHOD}/{{seed}}/rom.nc",
            losses=f"<results>/{{scene}}/{METHOD}/{{seed}}/losses.nc",
        log:
            f"<logs>/{{scene}}/{METHOD}/{{seed}}/fit.log",
        benchmark:
            f"<benchmarks>/{{scene}}/{METHOD}/{{seed}}/fit.tsv"
        priority: 50
        threads: BLOCK.get("resources", {}).get("threads", 1)
        resources:
            **{key: value for key, value in BLOCK.get("resources", {}).items() if key != "threads"},
        params:
            step="fit",
            recipe=recipe(METHOD),
            checkpoint=checkpoint(METHOD),
            provenance=code("fit", f"methods.{SETTINGS.kind_of(METHOD)}"),
        message:
            f"{{wildcards.scene}}: {METHOD} {{wildcards.seed}}: fit"
        script:
            "../scripts/step.py"
