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
        recipe = (SCENES[wildcards.scene], METHODS[method], fit_code(method)(wildcards))
        key = hashlib.sha256(repr(recipe).encode()).hexdigest()[:8]
        return str(Path(output.rom).with_name(f"checkpoint_{key}.npz"))

    return path


def of_equations(method):
    """Is it made from the equations of motion, without any motion?"""
    return constants("methods", SETTINGS.kind_of(method))["of_equations"]


def learnt_from(method):
    """The recorded motion, as the input `train`; none where the equations are enough."""
    train = "<results>/{scene}/full_order/train.nc"
    return {} if of_equations(method) else {"train": train}


def equations_of(method):
    """The blocks of the scene that make its equations of motion, for the methods that ask for them."""
    return {"scene": scene_part()} if of_equations(method) else {}


def fit_code(method):
    """The code of the fit and the method, and of the scene's effects where they are assembled."""

    def attributes(wildcards):
        effects = scene_modules(wildcards) if of_equations(method) else []
        return code("fit", f"methods.{SETTINGS.kind_of(method)}", *effects)

    return attributes


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
            **learnt_from(METHOD),
            structure=rules.structure.output.structure,
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
            **equations_of(METHOD),
            step="fit",
            recipe=recipe(METHOD),
            checkpoint=checkpoint(METHOD),
            provenance=fit_code(METHOD),
        message:
            f"{{wildcards.scene}}: {METHOD} {{wildcards.seed}}: fit"
        script:
            "../scripts/step.py"
