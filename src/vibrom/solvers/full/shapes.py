"""The check at the doors of the solvers: inside, compiled code trusts its arrays."""

import numpy as np


def shaped(name: str, values: np.ndarray, **extents: int) -> np.ndarray:
    """`values` as floats, whose shape must be these extents; else a ValueError that says so."""
    array = np.asarray(values, dtype=float)
    wanted = tuple(extents.values())
    if array.shape != wanted:
        names = ", ".join(extents) + ("," if len(extents) == 1 else "")
        raise ValueError(f"{name} has shape {array.shape}; needed is ({names}) = {wanted}")
    return array
