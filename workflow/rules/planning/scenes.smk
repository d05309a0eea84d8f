# The blocks of a scene, the code behind a result, a seed as a number, what scenes share.
from collections.abc import Callable
from typing import NamedTuple


def code(step, *modules):
    """The parameter `provenance`, with which a job runs again when the code behind it changes."""
    return provenance.attributes(
        f"vibrom.steps.{step}", *(f"vibrom.{module}" for module in modules)
    )


def seed_of(wildcards):
    """The seed as a number; None for a method that is fitted once."""
    return (
        None if wildcards.seed == settings.UNSEEDED else int(wildcards.seed.removeprefix("seed_"))
    )


def scene_part(*keys):
    """The blocks of the scene that a rule reads; a change in another one does not run it again.
    None of a recorded scene, which has no equations of motion.
    """
    return lambda wildcards: (
        None
        if wildcards.scene in RECORDED_SCENES
        else {key: SCENES[wildcards.scene][key] for key in ("body", "effects", *keys)}
    )


RECORDED_SCENES = [name for name, scene in SCENES.items() if scene.get("kind") == recordings.KIND]
WITH_BODY = [name for name in SCENES if name not in RECORDED_SCENES]


def among(scenes):
    """A regular expression of these names; of none where there are none."""
    return "|".join(map(re.escape, scenes)) or "(?!)"


def memory(kind):
    """What a job of this kind takes; of one for all scenes together, what the largest takes."""

    def megabytes(wildcards):
        scene = getattr(wildcards, "scene", None)
        return max(mem_mb(SCENES[name], kind) for name in ([scene] if scene else SCENES))

    return megabytes


def scene_modules(wildcards):
    """The modules of the scene's body and effects."""
    return SETTINGS.modules_of(wildcards.scene)


def full_order_code(step):
    """The code of a step that builds the full-order model, and of the scene's effects."""
    return lambda wildcards: code(step, *scene_modules(wildcards))


def recorded_files(wildcards):
    """The files that a scene names."""
    return list(dict.fromkeys(recordings.files_of(SCENES[wildcards.scene]).values()))


class Once(NamedTuple):
    """How an answer that several scenes of the run share is made in the first of them, and read
    there in the others: functions of a rule's wildcards.
    """

    inputs: Callable  # the answers of the first one as `same_<name>`
    step: Callable  # the step that makes them, or that reads them


def once(step, question, names, model):
    """Of answers with these names in the folder of `model`; `question`: scene with a body -> all
    that they depend on.
    """

    def first(wildcards):
        if wildcards.scene in RECORDED_SCENES:
            return wildcards.scene
        asked = question(wildcards.scene)
        return next(name for name in WITH_BODY if question(name) == asked)

    def inputs(wildcards):
        scene = first(wildcards)
        folder = f"<results>/{scene}/{model}".format(**dict(wildcards.items()))
        others = () if scene == wildcards.scene else names
        return {f"same_{name}": f"{folder}/{name}.nc" for name in others}

    return Once(inputs, lambda wildcards: "same" if inputs(wildcards) else step)
