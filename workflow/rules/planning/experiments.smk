# What an experiment reads and is given, and with which others it is asked in one job.
from graphlib import CycleError, TopologicalSorter
from typing import NamedTuple

EXPERIMENTS = {name: constants("experiments", name) for name in names("experiments")}
RECORDED = ("train", "test")  # decays of the full-order model


def full_order_names(scene):
    """What there is of the full-order model of a scene, whatever is asked."""
    return ["structure", *([] if scene in RECORDED_SCENES else ["release"]), *RECORDED]


def artefact(need, model):
    """Where `need` lies for the model in this folder; None where the full order has none."""
    if need in RECORDED:
        return f"<results>/{{scene}}/{settings.FULL_ORDER}/{need}.nc"
    if need == "fit":
        return None if model == settings.FULL_ORDER else f"<results>/{{scene}}/{model}/rom.nc"
    if model == settings.FULL_ORDER and not EXPERIMENTS[need]["of_full_order"]:
        # Its own answer is what others are compared with: the record.
        return artefact(EXPERIMENTS[need]["truth"], model)
    return f"<results>/{{scene}}/{model}/{need}.nc"


def in_order():
    """All experiments, each after those that it reads."""
    graph = {}
    for name, constants in EXPERIMENTS.items():
        for need in (*constants["reads"], constants["truth"]):
            if need not in (*RECORDED, "fit", *EXPERIMENTS, None):
                known = ", ".join((*RECORDED, "fit", *EXPERIMENTS))
                sys.exit(
                    f"vibrom: experiments/{name}.py: reads {need!r}, which no rule makes; "
                    f"choose from {known}"
                )
        graph[name] = [need for need in constants["reads"] if need in EXPERIMENTS]
    try:
        return list(TopologicalSorter(graph).static_order())
    except CycleError as error:
        sys.exit(f"vibrom: experiments read one another in a circle: {', '.join(error.args[1])}")


class Job(NamedTuple):
    """Experiments that are asked of a model in one job, each after those that it reads."""

    name: str
    experiments: tuple
    scenes: list  # in which it is that job


def jobs():
    """Those that name the same job are asked together where a scene takes part in all of them and
    they read no answers of other jobs; any other is a job of its own.
    """
    found = {}
    for scene in SCENES:
        together = {}
        for name in in_order():
            job, needs = EXPERIMENTS[name]["job"], set(EXPERIMENTS[name]["reads"])
            mates = together.setdefault(job, [])
            joins = job and name in SETTINGS.asked(scene) and needs <= {*mates, *RECORDED, "fit"}
            (mates if joins else together.setdefault((name,), [])).append(name)
        for job, members in together.items():
            if members:
                key = job if len(members) > 1 else members[0], tuple(members)
                found.setdefault(key, []).append(scene)
    named = {}
    for (name, members), scenes in found.items():
        name = "_".join([name, *scenes]) if name in named else name
        named[name] = Job(name, members, scenes)
    return list(named.values())


def reads(experiments, model):
    """What is read for the experiments of a job and not made there, by name, of the model in this
    folder.
    """
    wanted = [need for name in experiments for need in EXPERIMENTS[name]["reads"]]
    found = {need: artefact(need, model) for need in wanted if need not in experiments}
    return {need: path for need, path in found.items() if path is not None}


def truths(experiments):
    """What a reduced model's answers are compared with, as the inputs `truth_<experiment>`."""
    against = {name: EXPERIMENTS[name]["truth"] for name in experiments}
    return {
        f"truth_{name}": artefact(need, settings.FULL_ORDER)
        for name, need in against.items()
        if need is not None
    }


def waited_for(experiments):
    """The priority of their job: first what a study of all models together waits for."""

    def priority(wildcards):
        needed = {
            need
            for study, constants in STUDIES.items()
            for need in constants["reads"].get("models", ())
            if wildcards.scene in STUDY_SCENES[study]
        }
        return 0 if needed.isdisjoint(experiments) else 48

    return priority


def samples(wildcards):
    """Instants of a period that the full order stores, or a recording keeps at most."""
    if wildcards.scene in RECORDED_SCENES:
        return SCENES[wildcards.scene]["preparation"]["samples"]
    time = SCENES[wildcards.scene]["time"]
    return time["steps_per_period"] // time["every"]


def asked(experiments):
    """The scene's settings of each experiment."""
    return lambda wildcards: {
        name: SCENES[wildcards.scene]["experiments"].get(name, {}) for name in experiments
    }


def reduced_code(experiments):
    """The code of the experiments, of the fitted model and of the scene's signals."""
    modules = [f"experiments.{name}" for name in experiments]
    return lambda wildcards: code(
        "ask",
        *modules,
        *SETTINGS.signals_of(wildcards.scene),
        "models.reduced",
        method_module(wildcards.method),
    )


def read_for(experiment):
    """It, and all that it reads, directly or not."""
    needs = EXPERIMENTS[experiment]["reads"] if experiment in EXPERIMENTS else ()
    return {experiment}.union(*map(read_for, needs))


def answered_once(experiment):
    """Scenes with the same body, effects and time steps share what is asked alike of the full
    order.
    """
    needs = sorted(read_for(experiment))
    blocks = ["body", "effects", "time"]
    blocks += [] if set(RECORDED).isdisjoint(needs) else ["releases", "record"]

    def question(scene):
        made = SCENES[scene]
        return [made[block] for block in blocks] + [made["experiments"].get(need) for need in needs]

    return once("ask", question, (experiment,), settings.FULL_ORDER)


def full_order_answer_code(experiment):
    """The code of the experiment, of the full-order model and of the scene's effects and signals;
    of a recorded scene that of what was measured.
    """

    def attributes(wildcards):
        model = "measured" if wildcards.scene in RECORDED_SCENES else "full_order"
        own = f"experiments.{experiment}", f"models.{model}"
        signals = SETTINGS.signals_of(wildcards.scene)
        step = answered_once(experiment).step(wildcards)
        return code(step, *own, *scene_modules(wildcards), *signals)

    return attributes


JOBS = jobs()
