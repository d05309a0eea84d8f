# From scenes, methods, seeds and experiments to tables, figures, one report and MLflow.
#
#   snakemake --cores 2                 everything
#   snakemake --cores 2 tables          only these (or: figures)
#   snakemake --cores 2 cost            what accuracy costs in time
#   snakemake --cores 2 ablation        what each effect of a scene is worth; no model is trained
#   snakemake --cores 2 robustness      far from the training data
#   snakemake --list                    all rules; each method has its own
import re
import sys
from pathlib import Path

try:
    import vibrom
except ImportError:
    sys.exit(
        f"vibrom: the package is not installed for {sys.executable}; activate its environment, or "
        "make one (see README.md)"
    )

# A folder, or one of a repository elsewhere: then the package is the installed one, and the
# configuration that of the working folder.
HERE = workflow.current_basedir
ROOT = Path(HERE.get_path_or_uri(secret_free=True)) if HERE.is_local else Path()
OWN, RUNNING = ROOT / "src/vibrom", Path(vibrom.__file__).parent
if HERE.is_local and OWN.is_dir() and not OWN.samefile(RUNNING):
    sys.exit(
        f"vibrom: {RUNNING} would run, and not this checkout's {OWN}; activate the environment of "
        "this checkout, or make one (see README.md)"
    )

from vibrom.artefacts import provenance
from vibrom.config import errors, layers, settings
from vibrom.config import recorded as recordings
from vibrom.config.memory import mem_mb
from vibrom.config.plugs import constants, names

# The working folder's own, as that of a project that uses this workflow; else the one that is here.
CONFIG = Path("config") if Path("config/config.yaml").is_file() else ROOT / "config"
# Read here and not by Snakemake, for which `on`, 0200 and 1:30 are not what they look like. As a
# module this workflow is given a block by the other one, whose files and command are not for it.
GIVEN = (workflow.configfiles, workflow.config_settings.config)
if len(workflow.modifier_stack) > 1:
    GIVEN = ([], config, layers.MODULE)
try:
    SETTINGS = settings.load(CONFIG, *GIVEN)
except errors.ConfigError as error:
    sys.exit(f"vibrom: {error}")
SCENES = {name: scene.to_builtins() for name, scene in SETTINGS.scenes.items()}
METHODS = {name: method.to_builtins() for name, method in SETTINGS.methods.items()}


pathvars:
    results=SETTINGS.results,
    logs=f"{SETTINGS.results}/logs",
    benchmarks=f"{SETTINGS.results}/benchmarks",


wildcard_constraints:
    scene="|".join(map(re.escape, SCENES)),
    method="|".join(map(re.escape, METHODS)),
    seed=r"seed_\d+|unseeded",
    role="train|test",


include: "workflow/rules/planning/scenes.smk"
include: "workflow/rules/planning/progress.smk"
include: "workflow/rules/planning/resume.smk"
include: "workflow/rules/planning/unrecorded.smk"
include: "workflow/rules/full_order.smk"
include: "workflow/rules/recorded.smk"
include: "workflow/rules/methods.smk"
include: "workflow/rules/experiments.smk"
include: "workflow/rules/studies.smk"
include: "workflow/rules/results.smk"
include: "workflow/rules/families.smk"


rule all:
    default_target: True
    input:
        rules.scores.output,
        rules.tables.input,
        rules.figures.input,
        rules.report.output,
        rules.tracking.output,
        rules.crate.output,
        rules.headline.output,
    localrule: True
    message:
        "everything is there"
