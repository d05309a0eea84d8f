"""On what machine times were taken."""

import os
import platform
from pathlib import Path

import psutil

GIB = 2**30


class TooLarge(ValueError):
    """What is asked for does not fit into the memory of this machine; one line."""


def check_memory(size: float, what: str, cure: str) -> None:
    """Raise TooLarge before memory is taken that is not there; `size` [bytes] is of `what`."""
    free = psutil.virtual_memory().available
    if size > free:
        raise TooLarge(
            f"{what} takes {size / GIB:.3g} GiB of memory, and {free / GIB:.3g} GiB are free; "
            f"{cure}"
        )


def description() -> dict[str, str | int | float]:
    """Processor, its logical cores, memory [GiB], threads that the job was given, and how busy the
    machine was (load average of a minute).
    """
    listed = Path("/proc/cpuinfo")
    lines = listed.read_text().splitlines() if listed.is_file() else []
    model = next(
        (line.partition(":")[2].strip() for line in lines if line.startswith("model name")),
        platform.processor() or platform.machine(),
    )
    return {
        "processor": model,
        "cores": os.cpu_count() or 1,
        "memory_gib": round(psutil.virtual_memory().total / 2**30, 1),
        "threads": int(
            os.environ.get(
                "NUMBA_NUM_THREADS", os.environ.get("OMP_NUM_THREADS", os.cpu_count() or 1)
            )
        ),
        "load": round(psutil.getloadavg()[0], 2),
        "system": platform.system(),
    }
