"""The machine that took a time, in words."""

import os
import platform
from pathlib import Path


def description() -> str:
    """Processor and the cores that this process may use: `AMD EPYC 9654, 2 cores, x86_64`."""
    listing = Path("/proc/cpuinfo")
    lines = listing.read_text().splitlines() if listing.is_file() else []
    model = next((line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")), platform.processor() or "unknown processor")
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    return f"{model}, {cores} cores, {platform.machine()}"
