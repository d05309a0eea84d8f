# From scenes, methods, seeds and experiments to tables, figures, one report and MLflow.
#
#   snakemake --cores 2                 everything
#   snakemake --cores 2 tables          only these (or: figures)
#   snakemake --cores 2 cost            what accuracy costs in time
#   snakemake --cores 2 effects         what each effect of a scene is worth; no model is trained
#   snakemake --cores 2 stability       only the grid of hard cases
#   snakemake --list                    all rules; each method has its own
import sys
from pathlib import Path

from vibrom.config import files as config_files
from vibrom.artefacts import provenance
from vibrom.config import settings
from vibrom.config.plugs import constants, names

ROOT = Path(workflow.basedir)
CONFIG = ROOT / "config/config.yaml"


def checked(function, *arguments, **options):
    """The answer of the function; a wrong entry of the configuration is one line and the end."""
    try:
        return function(*arguments, **options)
    except config_files.SettingsError as error:
        sys.exit(f"vibrom: {error}")


checked(config_files.read, CONFIG)


configfile: str(CONFIG)


SETTINGS = checked(
    settings.load,
    config,
    folder=ROOT / "config",
    schemas=ROOT / "workflow/schemas",
    files=[name for name in workflow.configfiles if Path(name) != CONFIG],
)
SCENES, METHODS = SETTINGS.scenes, SETTINGS.methods


pathvars:
    results=SETTINGS.results,
    logs=f"{SETTINGS.results}/logs",
    benchmarks=f"{SETTINGS.results}/benchmarks",


wildcard_constraints:
    scene="|".join(SCENES),
    method="|".join(METHODS),
    seed=r"seed_\d+|unseeded",
    role="train|test",


def code(step, *modules):
    """What a rule passes on as `provenance`: it runs again when the code behind it changes."""
    return provenance.attributes(
        f"vibrom.steps.{step}", *(f"vibrom.{module}" for module in modules)
    )


def seed_of(wildcards):
    """The seed as a number; None for a method that is fitted once."""
    return (
        None if wildcards.seed == settings.UNSEEDED else int(wildcards.seed.removeprefix("seed_"))
    )


include: "workflow/rules/resume.smk"
include: "workflow/rules/full_order.smk"
include: "workflow/rules/methods.smk"
include: "workflow/rules/experiments.smk"
include: "workflow/rules/cost.smk"
include: "workflow/rules/results.smk"
include: "workflow/rules/effects.smk"
include: "workflow/rules/stability.smk"
include: "workflow/rules/families.smk"


rule all:
    default_target: True
    input:
        rules.scores.output,
        rules.tables.input,
        rules.figures.input,
        rules.report.output,
        rules.tracking.output,
        rules.headline.output,
    localrule: True
    message:
        "everything is there"
