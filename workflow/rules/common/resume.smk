# A run that was killed leaves its lock behind. When the process that took it is gone, the next run takes it over.
import os
import platform

RUNNING = Path(".snakemake/running")


def started(pid):
    """When a process of this machine started, in words that no other process with its number has;
    empty where it is gone, "unknown" where the system does not say.
    """
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return ""
    except PermissionError:
        pass
    try:
        boot = Path("/proc/sys/kernel/random/boot_id").read_text().strip()
        # In clock ticks since the machine started; the name before it may hold blanks.
        return f"{boot}:{Path(f'/proc/{pid}/stat').read_text().rpartition(')')[2].split()[19]}"
    except OSError:
        return "unknown"


def take_over():
    """Remove the locks of this folder if they are those of a dead process of this machine, and the
    files that its jobs were writing.

    A run that ends by itself, well or not, leaves no note of itself. A lock younger than the note is another run's that is just starting.
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


if workflow.is_main_process:
    take_over()


onstart:
    note()


onsuccess:
    RUNNING.unlink(missing_ok=True)


onerror:
    RUNNING.unlink(missing_ok=True)
