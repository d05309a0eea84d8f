# A run that was killed leaves its lock behind. When the process that took it is gone, the next run takes it over.
import os
import platform

RUNNING = Path(".snakemake/running")


def alive(pid):
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    except PermissionError:
        pass
    return True


def take_over():
    """Remove the locks of this folder if they are those of a dead process of this machine.

    A run that ends by itself, well or not, leaves no note of itself. A lock younger than the note is another run's that is just starting.
    """
    words = RUNNING.read_text().split() if RUNNING.is_file() else []
    if len(words) == 2 and words[0] == platform.node() and not alive(int(words[1])):
        for lock in Path(".snakemake/locks").glob("*.lock"):
            if lock.stat().st_mtime <= RUNNING.stat().st_mtime:
                lock.unlink()


def note():
    partial = RUNNING.with_suffix(".partial")
    partial.write_text(f"{platform.node()} {os.getpid()}\n")
    os.replace(partial, RUNNING)


take_over()


onstart:
    note()


onsuccess:
    RUNNING.unlink(missing_ok=True)


onerror:
    RUNNING.unlink(missing_ok=True)
