"""What was measured has the poles of its linear part."""

import numpy as np
import pytest
import xarray as xr

from vibrom.models.measured import Measured
from vibrom.models.training import Unsupported

OMEGA, ZETA = np.array([10.0, 30.0, 50.0]), np.array([0.01, 0.2, 1.5])


def test_poles_are_the_roots_of_each_mode_and_it_moves_no_more():
    """s^2 + 2 zeta omega s + omega^2 = 0, also of a mode that does not oscillate."""
    known = xr.Dataset(
        {"frequency": ("mode", OMEGA), "damping_ratio": ("mode", ZETA), "probe_dof": ("probe", [1])}
    ).assign_coords(dof=[0, 1])
    model = Measured.of_scene(known)
    roots = [np.roots([1.0, 2 * z * w, w**2]) for w, z in zip(OMEGA, ZETA)]
    np.testing.assert_allclose(
        np.sort_complex(model.eigenvalues()), np.sort_complex(np.concatenate(roots)), rtol=1e-9
    )
    assert model.frequency == pytest.approx(10.0 * np.sqrt(1 - 1e-4))
    with pytest.raises(Unsupported, match="this scene is a recording"):
        model.return_map()
