# What the fit of a method reads and is given.
import hashlib
from functools import cache


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
    """Where an interrupted training resumes; another scene, setting or code starts again."""

    def path(wildcards, output):
        recipe = (SCENES[wildcards.scene], METHODS[method], fit_code(method)(wildcards))
        key = hashlib.sha256(repr(recipe).encode()).hexdigest()[:8]
        return str(Path(output.rom).with_name(f"{key}.checkpoint"))

    return path


def rules_of_tool(path):
    """The file of an outside tool: of the working folder, or one that is here."""
    own = Path(path).absolute()
    return own if own.is_file() else HERE.join(path)


@cache
def of_equations(method):
    """Is it made from the equations of motion, without any motion?"""
    return constants("methods", SETTINGS.kind_of(method))["of_equations"]


def learnt_from(method):
    """The recorded motion, as the input `train`; none where the equations are enough."""
    train = "<results>/{scene}/full_order/train.nc"
    return {} if of_equations(method) else {"train": train}


def resources(method):
    """What its file asks for, else memory for the scene, and a GPU where networks are trained on
    one.
    """
    own = {"mem_mb": memory("equations" if of_equations(method) else "fit")}
    if SETTINGS.device.startswith("cuda") and METHODS[method]["seeded"]:
        own["gpu"] = 1
    given = METHODS[method].get("resources", {})
    return own | {key: value for key, value in given.items() if key != "threads"}


def fitted_once(method):
    """Scenes with the same equations of motion share what is made from nothing else."""

    def question(scene):
        made = SCENES[scene]
        return [made["body"], made["effects"]] if of_equations(method) else scene

    return once("fit", question, ("rom", "losses"), f"{method}/{{seed}}")


def equations_of(method):
    """The blocks that make a scene's equations of motion, for the methods that ask for them."""
    return {"scene": scene_part()} if of_equations(method) else {}


def fit_code(method):
    """The code of the fit and the method, and of the scene's effects where they are assembled."""

    def attributes(wildcards):
        effects = scene_modules(wildcards) if of_equations(method) else []
        step = fitted_once(method).step(wildcards)
        return code(step, f"methods.{SETTINGS.kind_of(method)}", *effects)

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


def method_module(method):
    """The module of a method, or of the models that an outside method stores."""
    outside = METHODS[method].get("rom_class")
    if outside:
        return outside.split(":")[0].removeprefix("vibrom.")
    return f"methods.{SETTINGS.kind_of(method)}"
