# A run that was killed leaves its lock behind. When the process that took it is gone, the next run
# takes it over.
import os
import platform

from vibrom.artefacts.processes import started

RUNNING = Path(".snakemake/running")


def take_over():
    """Remove the locks of this folder if they are those of a dead process of this machine, and the
    files that its jobs were writing.

    A run that ends by itself, well or not, leaves no note of itself. A lock younger than the note
    is another run's that is just starting.
    """
    words = RUNNING.read_text().split() if RUNNING.is_file() else []
    if len(words) == 3 and words[0] == platform.node() and words[2] != started(int(words[1])):
        for lock in Path(".snakemake/locks").glob("*.lock"):
            if lock.stat().st_mtime <= RUNNING.stat().st_mtime:
                lock.unlink()
        for partial in Path(SETTINGS.results).rglob(".*.partial"):
            partial.unlink(missing_ok=True)


def note():
    partial = RUNNING.with_suffix(".partial")
    partial.write_text(f"{platform.node()} {os.getpid()} {started(os.getpid())}\n")
    os.replace(partial, RUNNING)


def unlimited():
    """Jobs on this machine start when there is room. Snakemake's limit of jobs a second, for the
    sake of a cluster's queue, would look for new ones again a second after every job, and once
    begun for ever: after some hundred jobs that takes a quarter of a core.
    """
    if workflow.resource_settings.nodes is None:
        workflow.scheduler.job_rate_limiter = None


if workflow.is_main_process:
    take_over()


onstart:
    note()
    unlimited()


onsuccess:
    RUNNING.unlink(missing_ok=True)


onerror:
    RUNNING.unlink(missing_ok=True)
