# Snakemake knows by its records with what settings a file was made. A results folder that was
# copied or cloned has none, and neither has a file that was put in place by hand: what such an
# artefact says of itself is compared with what its rule asks for, and it is made again where the
# two differ.
import time
from base64 import urlsafe_b64encode

RECORDS = Path(".snakemake/metadata")
DELAY = 60  # s; a record is written soon after its file
SHOWN = 3  # lines about artefacts that are made again
PLANNED = set()  # scenes that were looked through


def recorded(path):
    """Has Snakemake a record of this very file? (Kept in a file that is named by the path.)"""
    try:
        noted = (RECORDS / urlsafe_b64encode(path.encode()).decode()).stat().st_mtime
    except OSError:
        return False
    return noted - DELAY <= Path(path).stat().st_mtime <= noted


def stale(path):
    """Why the artefact is not what its rule would make now, or None."""
    from vibrom.artefacts import identity  # opens files, which most plans need not

    maker = next(item for item in workflow.rules if item.is_producer(path))
    wildcards = maker.get_wildcards(path)
    inputs, output = maker.expand_input(wildcards)[0], maker.expand_output(wildcards)[0]
    params = dict(maker.expand_params(wildcards, inputs, output, None)[0].items())
    found = {
        name: paths if isinstance(paths, str) else list(paths)
        for name, paths in inputs.items()
        if all(Path(each).is_file() for each in ([paths] if isinstance(paths, str) else paths))
    }
    return identity.stale(path, params, params["provenance"], found)


def bring_back():
    """Files of the future, as of a clock that was set back, become files of now: Snakemake would
    refuse, until then, all that is made from them.
    """
    now = time.time()
    for path in Path(SETTINGS.results).rglob("*"):
        if path.is_file() and path.stat().st_mtime > now + 1.0:
            os.utime(path, (now, now))


def make_again(wildcards):
    """No input of the rule `structure`, but what Snakemake calls while it plans, as every plan has
    that rule: stale artefacts of the scene join those that are to be made in any case.
    """
    if wildcards.scene in PLANNED or not workflow.is_main_process:
        return {}
    if not PLANNED:
        bring_back()
    PLANNED.add(wildcards.scene)
    known = [path.replace("<results>", SETTINGS.results) for path in all_artefacts()]
    mine = [path for path in known if path.startswith(f"{SETTINGS.results}/{wildcards.scene}/")]
    unknown = [path for path in mine if Path(path).is_file() and not recorded(path)]
    reasons = {path: why for path in unknown if (why := stale(path))}
    for path, why in [*reasons.items()][:SHOWN]:
        print(f"vibrom: {path}: {why}; it is made again", file=sys.stderr)
    if len(reasons) > SHOWN:
        print(f"vibrom: and {len(reasons) - SHOWN} more of {wildcards.scene}", file=sys.stderr)
    workflow.dag.forcefiles.update(reasons)
    return {}
