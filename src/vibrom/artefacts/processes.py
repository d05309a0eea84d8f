"""Processes of this machine, told apart from later ones with the same number."""

import os
from pathlib import Path


def started(pid: int) -> str:
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
