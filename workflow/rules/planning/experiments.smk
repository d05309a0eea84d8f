# What an experiment reads and is given.

EXPERIMENTS = {name: constants("experiments", name) for name in names("experiments")}
RECORDED = ("train", "test")  # decays of the full-order model
# What there is of the full-order model of a scene.
FULL_ORDER_NAMES = (
    "structure",
    "release",
    *RECORDED,
    *(name for name in ("forced", "frc") if EXPERIMENTS[name]["of_full_order"]),
)


def artefact(experiment, need, model):
    """Where `need` lies for the model in this folder; None where the full order has none."""
    if need in RECORDED:
        return f"<results>/{{scene}}/{settings.FULL_ORDER}/{need}.nc"
    if need == "fit":
        return None if model == settings.FULL_ORDER else f"<results>/{{scene}}/{model}/rom.nc"
    if need not in EXPERIMENTS:
        known = ", ".join((*RECORDED, "fit", *EXPERIMENTS))
        sys.exit(
            f"vibrom: experiments/{experiment}.py: reads {need!r}, which no rule makes; "
            f"choose from {known}"
        )
    if model == settings.FULL_ORDER and not EXPERIMENTS[need]["of_full_order"]:
        # Its own answer is what others are compared with: the record.
        return artefact(experiment, EXPERIMENTS[need]["truth"], model)
    return f"<results>/{{scene}}/{model}/{need}.nc"


def reads(experiment, model):
    """The inputs of an experiment by name, for the model in this folder."""
    wanted = EXPERIMENTS[experiment]["reads"]
    found = {need: artefact(experiment, need, model) for need in wanted}
    return {need: path for need, path in found.items() if path is not None}


def truth(experiment):
    """What a reduced model's answer is compared with, as the input `truth`."""
    against = EXPERIMENTS[experiment]["truth"]
    return {} if against is None else {"truth": artefact(experiment, against, settings.FULL_ORDER)}


def samples(wildcards):
    """Instants of a period that the full order stores."""
    time = SCENES[wildcards.scene]["time"]
    return time["steps_per_period"] // time["every"]


def asked(experiment):
    """The scene's settings of an experiment."""
    return lambda wildcards: SCENES[wildcards.scene]["experiments"].get(experiment, {})


def reduced_code(experiment):
    """The code of the experiment and of the fitted model."""
    return lambda wildcards: code(
        "ask", f"experiments.{experiment}", "models.reduced", method_module(wildcards.method)
    )


def full_order_answer_code(experiment):
    """The code of the experiment, of the full-order model and of the scene's effects."""
    return lambda wildcards: code(
        "ask", f"experiments.{experiment}", "models.full_order", *scene_modules(wildcards)
    )
