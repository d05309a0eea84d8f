"""From recorded motion to what a method learns from.

Velocity and acceleration are either the integrator's own, or sixth-order central differences of the
displacements, as for data that someone measured:  h y' = sum_k c_k y_k,  h^2 y'' = sum_k d_k y_k
over seven samples (Fornberg, Math. Comp. 51 (1988) 699); three samples are lost at each end.
"""

import numpy as np
import xarray as xr
from scipy.sparse import csr_matrix

from vibrom.artefacts.data import DataError
from vibrom.models.samples import Samples
from vibrom.models.training import Structure, Trajectory

STENCIL = 7  # samples
FIRST = np.array([-1 / 60, 3 / 20, -3 / 4, 0.0, 3 / 4, -3 / 20, 1 / 60])
SECOND = np.array([1 / 90, -3 / 20, 3 / 2, -49 / 18, 3 / 2, -3 / 20, 1 / 90])


def differences(
    displacement: np.ndarray, step: float, some: slice = slice(None)
) -> tuple[np.ndarray, np.ndarray]:
    """(velocity, acceleration) (m - 6, n) at the inner samples of `displacement` (m, n), `step`
    seconds apart, or at `some` of these.

    Take them before thinning the samples: motion of the higher modes between thinned samples would
    spoil them.
    """
    inner = len(displacement) - len(FIRST) + 1
    if inner < 1:
        raise DataError(
            f"{len(displacement)} samples are too few for differences over {len(FIRST)}; record a "
            "longer decay"
        )
    windows = [displacement[shift : shift + inner][some] for shift in range(len(FIRST))]
    velocity = sum(c * w for c, w in zip(FIRST, windows) if c) / step
    return velocity, sum(c * w for c, w in zip(SECOND, windows)) / step**2


def released(release: xr.Dataset, role: str) -> np.ndarray:
    """(2n,) displacement from rest [m] and velocity [m/s] of a release."""
    state = release.sel(role=role)
    shape = state["displacement"].values
    speed = state["velocity"].values if "velocity" in state else np.zeros_like(shape)
    return np.concatenate([shape, speed])


def trajectories(dataset: xr.Dataset, *, lazy: bool = False) -> tuple[Trajectory, ...]:
    """The finite parts of recorded decays: one, or several that follow one another; `lazy` of a
    dataset that is open, from which a sample is read when it is needed.
    """
    if "part" not in dataset:
        return (trajectory(dataset, lazy=lazy),)
    part = dataset["part"].values
    each = (dataset.isel(time=part == number) for number in np.unique(part))
    return tuple(trajectory(one, lazy=lazy) for one in each)


def trajectory(dataset: xr.Dataset, *, lazy: bool = False) -> Trajectory:
    """The finite part of a recorded decay; of several, one after the other."""
    parts = [dataset[name].variable for name in ("displacement", "velocity", "acceleration")]
    finite = Samples(((parts[0],),)).map(lambda block: np.isfinite(block).all(axis=1))
    if not lazy or not finite.all():
        parts = [part[finite] if lazy else part.values[finite] for part in parts]
    return Trajectory(dataset["time"].values[finite], *parts)


def structure(dataset: xr.Dataset) -> Structure | None:
    """The operators and modes of a scene; None where only motion is known."""
    if "mass_value" not in dataset:
        return None
    n = dataset.sizes["dof"]

    def operator(name: str) -> csr_matrix:
        if f"{name}_value" not in dataset:
            return csr_matrix((n, n))
        return csr_matrix(
            (
                dataset[f"{name}_value"].values,
                (dataset[f"{name}_row"].values, dataset[f"{name}_column"].values),
            ),
            shape=(n, n),
        )

    return Structure(
        operator("mass"),
        operator("damping"),
        operator("stiffness"),
        dataset["mode_shape"].values,
        dataset["frequency"].values,
    )


def damped_frequency(known: xr.Dataset) -> float:
    """omega_1 sqrt(1 - zeta_1^2) [rad/s] of a scene's structure."""
    first = known.isel(mode=0)
    return float(first["frequency"]) * np.sqrt(1.0 - float(first["damping_ratio"]) ** 2)
