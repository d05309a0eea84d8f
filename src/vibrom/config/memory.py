"""How much memory a job takes, from the size of its scene alone.

    mem = program + b n (PER_DISPLACEMENT + FACTOR (2 + across)) + a D,    D = 8 m n

n displacements and m stored samples, of a decay or of the experiment `response`; `across` is what
stands in a line across the body, about half the band of its matrices. A kind of job holds what a
body is made of b times, and a arrays of the size of all recorded displacements: fits and full-order
runs none, as they read and write these in blocks. These are bounds; what jobs took is held against
them by tests/workflow/test_small_dag.py and, for 60 000 displacements, by benchmarks/memory.py.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import prod
from pathlib import Path
from typing import Any

from vibrom.config.recorded import files_of

MB = 1e6  # bytes
PER_DISPLACEMENT = 0.016  # MB, of elements, matrices and a few states
FACTOR = 24 / MB  # MB, of a number in tangent, factor and what they are made from
BYTES_OF_NODE = 30  # in a mesh file, its elements included, at least
OBSERVABLES = 5  # that a recorded channel makes, at most
# Kind of job -> what Python, its packages (torch, where networks are), compiled code and blocks of
# rows take [MB], b, a. Fits have directions and coefficients of all displacements. Answers hold
# the recorded decay, the model's and what compares them; studies those of several models; sinks
# the recorded decays of a scene.
HELD = {
    "full_order": (700, 1, 0),
    "fit": (1400, 0.5, 0),
    "equations": (1400, 2, 0),
    "answer": (1400, 0, 12),
    "full_order_answer": (1400, 1, 6),
    "study": (1400, 1, 16),
    "sink": (1400, 0, 9),
}


def mem_mb(scene: dict[str, Any], kind: str) -> int:
    """Of a job of this kind, in MB of 1e6 bytes; `scene` in plain form."""
    program, bodies, arrays = HELD[kind]
    if "body" not in scene:
        files = sum(float(Path(file).stat().st_size) for file in files_of(scene).values())
        return int(program + max(arrays, 3) * OBSERVABLES * files / MB)
    n, across = size(scene["body"])
    time = scene["time"]
    asked = scene.get("experiments", {}).get("response", {})  # keeps all displacements, too
    periods = max(scene["record"]["periods"], asked.get("periods", 0))
    samples = periods * time["steps_per_period"] // time["every"] + 1
    each = n * (PER_DISPLACEMENT + FACTOR * (2 + across))
    return int(program + bodies * each + arrays * 8 * samples * n / MB)


def size(body: Mapping[str, Any]) -> tuple[int, int]:
    """(displacements, those in a line across the body), clamped ones included."""
    if "mesh" in body:
        nodes = Path(body["mesh"]).stat().st_size // BYTES_OF_NODE
        nodes *= 4 if body.get("order") == 2 else 1
        return 3 * nodes, 3 * int(nodes ** (2 / 3))
    each = 2 if body.get("element") in ("quadratic", "serendipity") else 1
    lines = sorted(each * count + 1 for count in body["cells"])
    return len(lines) * prod(lines), len(lines) * each * prod(lines[:-1])
