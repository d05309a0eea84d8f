"""How much memory a job takes, from the size of its scene alone.

    mem = program + b n (PER_DISPLACEMENT + FACTOR (2 + across)) + a D,    D = 8 m n

n displacements and m stored samples of a decay; `across` is what stands in a line across the body,
about half the band of its matrices. A kind of job holds what a body is made of b times, and a
arrays of the size of a decay: full-order runs, fits, answers and studies none, as they write and
read motions in blocks. These are bounds; what jobs took is held against them by
tests/workflow/test_small_dag.py and, for larger bodies, by benchmarks/memory.py.
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
WHOLE = 12  # arrays, where recorded channels are read whole: they are few
# Kind of job -> what Python, its packages (torch, where networks are), compiled code and blocks of
# rows take [MB], b, a. Fits have directions and coefficients of all displacements, and so have
# answers. Sinks have frames of motions.
HELD = {
    "full_order": (700, 1, 0),
    "fit": (1400, 0.5, 0),
    "equations": (1400, 2, 0),
    "answer": (1400, 0.5, 0),
    "full_order_answer": (1400, 1, 0),
    "study_scene": (1400, 1, 0),
    "study_model": (1400, 1, 0),
    "study_models": (1400, 1, 0),
    "sink": (1400, 0.5, 0.5),
    "whole": (1400, 0, WHOLE),
}


def mem_mb(scene: dict[str, Any], kind: str) -> int:
    """Of a job of this kind, in MB of 1e6 bytes; `scene` in plain form."""
    program, bodies, arrays = HELD[kind]
    if "body" not in scene:
        files = sum(float(Path(file).stat().st_size) for file in files_of(scene).values())
        return int(program + WHOLE * OBSERVABLES * files / MB)
    n, across = size(scene["body"])
    samples = scene["time"]["steps_per_period"] // scene["time"]["every"]
    decay = 8 * n * (scene["record"]["periods"] * samples + 1) / MB
    each = n * (PER_DISPLACEMENT + FACTOR * (2 + across))
    return int(program + bodies * each + arrays * decay)


def size(body: Mapping[str, Any]) -> tuple[int, int]:
    """(displacements, those in a line across the body), clamped ones included."""
    if "mesh" in body:
        nodes = Path(body["mesh"]).stat().st_size // BYTES_OF_NODE
        nodes *= 4 if body.get("order") == 2 else 1
        return 3 * nodes, 3 * int(nodes ** (2 / 3))
    each = 2 if body.get("element") in ("quadratic", "serendipity") else 1
    lines = sorted(each * count + 1 for count in body["cells"])
    return len(lines) * prod(lines), len(lines) * each * prod(lines[:-1])
