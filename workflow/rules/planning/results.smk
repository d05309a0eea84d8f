# Which artefacts the tables, figures and the report are made from.
from itertools import product
from typing import NamedTuple

from vibrom.report import outputs

# Every model of the run as (scene, method, seed folder).
MODELS = [
    (scene, method, seed)
    for scene in SCENES
    for method in METHODS
    for seed in SETTINGS.seed_folders(method)
]


def of_full_order(scenes, names):
    return [
        f"<results>/{scene}/{settings.FULL_ORDER}/{name}.nc" for scene in scenes for name in names
    ]


def of_models(scenes, names):
    return [
        f"<results>/{'/'.join(model)}/{name}.nc"
        for model in MODELS
        if model[0] in scenes
        for name in names
    ]


def predictions(scene):
    """What all models of a scene answer."""
    names = SETTINGS.asked(scene)
    evaluated = [name for name in names if EXPERIMENTS[name]["of_full_order"]]
    return of_models([scene], names) + of_full_order([scene], evaluated)


PREDICTIONS = [path for scene in SCENES for path in predictions(scene)]
# Besides answers, what scores are read from: the work balance of the records and of the models.
SCORED = PREDICTIONS + of_full_order(SCENES, RECORDED)
SCORED += study_files("trust") if "trust" in STUDY_SCENES else []
FITTED = of_models(SCENES, ("rom", "losses"))
ARTEFACTS = [path for scene in SCENES for path in of_full_order([scene], full_order_names(scene))]
ARTEFACTS += FITTED + PREDICTIONS


class Family(NamedTuple):
    """Tables and figures that are made from one set of artefacts."""

    scenes: list  # a family without scenes has no tables and figures
    artefacts: list


def of_study(study):
    """The artefacts of a study, the scenes' structures, and what it reads of the full order."""
    reads = [need for needs in STUDIES[study]["reads"].values() for need in needs]
    known = [need.removeprefix("full_order/") for need in reads if need.startswith("full_order/")]
    return study_files(study) + of_full_order(STUDY_SCENES[study], ["structure", *known])


def artefacts_of(family):
    """Its own, and those of other studies that its tables and figures need."""
    own = ARTEFACTS if family == outputs.MODELS else of_study(family)
    others = [study for study in outputs.also(family) if study in STUDIES]
    return list(dict.fromkeys(own + [path for study in others for path in of_study(study)]))


for NAME in outputs.families():
    if NAME not in (outputs.MODELS, *names("studies")):
        sys.exit(
            f"vibrom: FAMILY {NAME!r} of a table or figure is no study; see src/vibrom/studies"
        )
SHOWN_SCENES = {outputs.MODELS: list(SCENES), **STUDY_SCENES}
FAMILIES = {
    name: Family(SHOWN_SCENES[name], artefacts_of(name))
    for name in outputs.families()
    if name in SHOWN_SCENES
}
PRESENT = [name for name, family in FAMILIES.items() if family.scenes]
ASKED = [name for name in SETTINGS.experiments if any(name in SETTINGS.asked(s) for s in SCENES)]
TABLES = {name: outputs.tables(name, ASKED) for name in PRESENT}
FIGURES = {
    name: outputs.figures(name, FAMILIES[name].scenes, RECORDED_SCENES, SETTINGS.asked)
    for name in PRESENT
}
MADE = {"tables": TABLES, "figures": FIGURES}


def files(kind, families=PRESENT, forms=None):
    """The tables or figures of these families, in these formats or in all."""
    return [
        f"<results>/{kind}/{name}.{form}"
        for family in families
        for name in MADE[kind].get(family, ())
        for form in forms or outputs.FORMATS[kind]
    ]


def modules(kind, families=PRESENT):
    """The code behind them."""
    return [module for family in families for module in outputs.modules(kind, family)]


def all_artefacts():
    """Of all families, each once."""
    return list(dict.fromkeys(path for name in PRESENT for path in FAMILIES[name].artefacts))


def behind(artefacts):
    """Artefacts that a sink reads and that its inputs are made from, as its parameter. As inputs of
    their own, a thousand of them would cost every plan a tenth of a second.
    """
    return lambda wildcards, output: [
        path.replace("<results>", str(Path(output[0]).parent)) for path in artefacts
    ]


def plugs_shown(kind):
    """The tables by name, the figures by the file that draws them."""
    if kind == "tables":
        return [name for names in TABLES.values() for name in names]
    return list(
        dict.fromkeys(drawing.plug for names in FIGURES.values() for drawing in names.values())
    )


class Part(NamedTuple):
    """Tables or figures of a family that are made together: those of the run, or of one scene."""

    name: str  # of the rule
    family: str
    kind: str
    scenes: list  # that have these; of the run: all
    plugs: dict  # output, with the wildcard {scene}, -> file that makes it

    @property
    def folder(self):
        """Below logs and benchmarks."""
        return "{scene}/" if any("{scene}" in name for name in self.plugs) else ""


def parts():
    """Those of the run, and those of the scenes that have the same figures."""
    for family, kind in product(PRESENT, MADE):
        by_scene = {}
        for name in MADE[kind].get(family, ()):
            plug, scene = (name, None) if kind == "tables" else FIGURES[family][name]
            by_scene.setdefault(scene, {})[plug if scene is None else f"{plug}_{{scene}}"] = plug
        if of_run := by_scene.pop(None, None):
            yield Part(f"{family}_{kind}", family, kind, list(SCENES), of_run)
        alike = {}
        for scene, plugs in by_scene.items():
            alike.setdefault(tuple(plugs), []).append(scene)
        for number, scenes in enumerate(alike.values()):
            name = f"{family}_{kind}_of_scene" + (f"_{number + 1}" if number else "")
            yield Part(name, family, kind, scenes, by_scene[scenes[0]])


def not_asked(part):
    """What a run of all experiments has besides, of the run or of a scene."""
    if part.kind == "tables":
        every = outputs.tables(part.family, EXPERIMENTS)
        return [name for name in every if name not in part.plugs]
    every = outputs.figures(part.family, SCENES, RECORDED_SCENES)
    others = {name: each.scene for name, each in every.items() if name not in FIGURES[part.family]}

    def names(wildcards):
        here = getattr(wildcards, "scene", None)
        return [name for name, scene in others.items() if scene == here]

    return names


def in_report(part):
    """Its outputs: .html of tables and .svg of figures appear in Snakemake's report."""
    return [
        (
            shown(part.kind, name, plug, form)
            if form in ("html", "svg")
            else f"<results>/{part.kind}/{name}.{form}"
        )
        for name, plug in part.plugs.items()
        for form in outputs.FORMATS[part.kind]
    ]


def shown(kind, name, plug, form):
    return report(
        f"<results>/{kind}/{name}.{form}",
        caption=caption_file(kind, plug),
        category=kind.capitalize(),
        labels={kind[:-1]: name.replace("_", " ")},
    )


def made_from(part):
    """The artefacts behind them, those of the run or of a scene."""
    paths = FAMILIES[part.family].artefacts
    if not part.folder:
        return paths
    return lambda wildcards: [
        path for path in paths if path.startswith(f"<results>/{wildcards.scene}/")
    ]


def scored(part):
    """The scores of the run, as the input `scores` of what shows all scenes; those of one scene are
    read from its own artefacts, as soon as it is through.
    """
    whole = part.family == outputs.MODELS and not part.folder
    return {"scores": rules.scores.output.scores} if whole else {}


def caption_file(kind, plug):
    """Snakemake takes captions from files: written where it keeps its own."""
    path = Path(".snakemake/captions", kind, f"{plug}.rst").absolute()
    text = outputs.captions({kind: [plug]}, SCENES)[f"{kind}/{plug}"].rst
    if not path.is_file() or path.read_text(encoding="utf-8") != text:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    return str(path)
