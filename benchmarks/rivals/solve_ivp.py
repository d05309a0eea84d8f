"""A reduced model simulated with SciPy: `solve_ivp`, DOP853, one run after the other.

The right-hand side is the model's own `drift` and `force_map` in numpy. A run ends early, by a
terminal event, where ours does: beyond `limit` in any coordinate.
"""

import numpy as np
from scipy.integrate import solve_ivp


def simulate(
    rom,
    start: np.ndarray,
    times: np.ndarray,
    rtol: float,
    atol: np.ndarray,
    limit: np.ndarray,
    load: np.ndarray | None = None,
    amplitude: float = 0.0,
    frequency: float = 0.0,
) -> np.ndarray:
    """z (m, r) at `times` (m,) from `start` (r,) at t = 0, NaN after the end of a run that ended
    early; the load p (n,) acts as p a sin(w t).
    """

    def free(t, z):
        return rom.drift(z)

    def driven(t, z):
        return rom.drift(z) + rom.force_map(z, load) * (amplitude * np.sin(frequency * t))

    def blown(t, z):
        return np.max(np.abs(z) / limit) - 1.0

    blown.terminal = True
    with np.errstate(all="ignore"):
        found = solve_ivp(
            free if load is None else driven,
            (0.0, times[-1]),
            start,
            method="DOP853",
            t_eval=times,
            rtol=rtol,
            atol=atol,
            events=blown,
        )
    reduced = np.full((len(times), len(start)), np.nan)
    reduced[: len(found.t)] = np.reshape(found.y, (len(start), -1)).T
    return reduced
