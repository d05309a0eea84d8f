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
    """Remove the locks of this folder if they are those of a dead process of this machine."""
    if RUNNING.is_file():
        host, pid = RUNNING.read_text().split()
        if host == platform.node() and not alive(int(pid)):
            for lock in Path(".snakemake/locks").glob("*.lock"):
                lock.unlink()


take_over()


onstart:
    RUNNING.write_text(f"{platform.node()} {os.getpid()}\n")
