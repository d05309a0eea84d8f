"""On what machine times were taken."""

import os
import platform
from pathlib import Path

import psutil


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
