# What the jobs of a study read and are given.

STUDIES = {name: constants("studies", name) for name in SETTINGS.studies}
STUDY_SCENES = {name: block["scenes"] for name, block in SETTINGS.studies.items()}
EVERY_MODEL = [
    f"{method}/{folder}" for method in METHODS for folder in SETTINGS.seed_folders(method)
]
JOB_FOLDER = {"model": "{method}/{seed}"}  # of the others: that of the full order


def study_files(study):
    """All artefacts of a study."""
    return [
        f"<results>/{scene}/{folder}/{artefact}.nc"
        for scene in STUDY_SCENES[study]
        for kind, artefact in STUDIES[study]["jobs"].items()
        for folder in (EVERY_MODEL if kind == "model" else [settings.FULL_ORDER])
    ]


def job_reads(study, kind):
    """What a job reads of the full order, and its fitted models: of each the fit, then answers."""
    reads = STUDIES[study]["reads"].get(kind, ())
    own = ["rom", *(need for need in reads if "/" not in need)]
    models = {"scene": [], "model": [JOB_FOLDER["model"]], "models": EVERY_MODEL}[kind]
    return {
        "full_order": [f"<results>/{{scene}}/{need}.nc" for need in reads if "/" in need],
        "fitted": [f"<results>/{{scene}}/{model}/{need}.nc" for model in models for need in own],
    }


def job_settings(study, kind):
    """The settings that a job depends on."""
    block = SETTINGS.studies[study]
    names = STUDIES[study]["settings"].get(kind, [name for name in block if name != "scenes"])
    return {"name": study, "kind": kind, "settings": {name: block[name] for name in names}}


def job_names(wildcards):
    """Scene, method and seed of an artefact."""
    of_model = hasattr(wildcards, "method")
    return {
        "scene": wildcards.scene,
        "method": wildcards.method if of_model else settings.FULL_ORDER,
        "seed": seed_of(wildcards) if of_model else None,
    }


def recipes():
    """How each method of the run is fitted; one without a kind is fitted outside."""
    return {
        method: {
            "kind": None if "rule" in block else SETTINGS.kind_of(method),
            "settings": block.get("settings", {}),
            "seeded": block["seeded"],
            "start": block.get("starts_from"),
        }
        for method, block in METHODS.items()
    }


def job_case(study, kind):
    """What a job is given besides artefacts."""

    def case(wildcards):
        scene = SCENES[wildcards.scene]
        blocks = {key: scene[key] for key in ("body", "effects", "record", "time")}
        asked = {
            name: scene["experiments"][name]
            for name in STUDIES[study]["experiments"]
            if name in scene["experiments"]
        }
        given = {"scene": blocks | {"experiments": asked}}
        if kind != "scene":
            given["integrator"] = SETTINGS.integrator
        if kind == "models":
            given |= {"methods": recipes(), "seed": SETTINGS.seeds[0], "device": SETTINGS.device}
        return given

    return case


def job_code(study, kind):
    """The code of the study, of the experiments that it evaluates, of the scene, its signals and
    the models.
    """
    constants = STUDIES[study]
    own = [f"studies.{study}", *(f"experiments.{name}" for name in constants["experiments"])]
    own += [constants["parts"][kind]] if kind in constants["parts"] else []

    def attributes(wildcards):
        chosen = {"scene": [], "model": [getattr(wildcards, "method", None)], "models": METHODS}
        models = sorted({method_module(method) for method in chosen[kind]})
        schemes = [f"solvers.full.schemes.{name}" for name in names("solvers/full/schemes")]
        varied = schemes if kind == "scene" else []
        signals = SETTINGS.signals_of(wildcards.scene)
        return code("study", *own, *scene_modules(wildcards), *signals, *models, *varied)

    return attributes
