"""The different states from which the beams of a run are released, from the smallest to the
largest.
"""

from typing import NamedTuple

import numpy as np
import xarray as xr

from vibrom.report.collection import FULL_ORDER, Collection, probe_dof, probe_name
from vibrom.report.drawing import body


class State(NamedTuple):
    """One of them."""

    structure: xr.Dataset
    displacement: np.ndarray  # (dof,) [m]
    used: list[str]  # "small test", ...

    @property
    def shown(self) -> dict[str, float]:
        """Displacement [m] of the probe that tables show, and of `tip` where that is another."""
        names = dict.fromkeys((probe_name(self.structure), "tip"))
        found = {name: probe_dof(self.structure, name) for name in names}
        return {
            name: float(self.displacement[dof]) for name, dof in found.items() if dof is not None
        }


def states(collection: Collection) -> list[State]:
    """One for each different displacement: what one scene trains on another may be tested on."""
    found: list[State] = []
    for scene in collection.scenes:
        structure, release = (
            collection.find(scene, FULL_ORDER, name) for name in ("structure", "release")
        )
        if structure is None or release is None:
            continue
        for role in release["role"].values:
            free = release["displacement"].sel(role=role).values
            same = [
                state
                for state in found
                if state.displacement.shape == free.shape
                and np.allclose(state.displacement, free, rtol=0, atol=1e-6 * np.abs(free).max())
            ]
            if same:
                same[0].used.append(f"{scene} {role}")
            else:
                found.append(State(structure, free, [f"{scene} {role}"]))
    return sorted(
        found, key=lambda state: float(body.magnitude(state.structure, state.displacement).max())
    )
