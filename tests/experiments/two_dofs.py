"""Two masses on springs, as a full-order model, as a reduced one that is exact, and as data.

M q'' + c M q' + K q = p u(t),    q = sum_k phi_k z_k,    z_k'' + c z_k' + omega_k^2 z_k = p_k u
"""

import numpy as np
import xarray as xr
from scipy.linalg import eigh
from scipy.sparse import csr_matrix

from vibrom.artefacts.data import label, outcome_variables, variable
from vibrom.experiments import Given
from vibrom.latent.polynomial_rom import PolynomialRom
from vibrom.models.full_order import FullOrder
from vibrom.models.reduced import Reduced
from vibrom.models.rollout import Integrator
from vibrom.solvers.full.newmark import Newmark
from vibrom.term import Term

MASS, STIFFNESS = np.diag([2.0, 1.0]), np.array([[3.0, -1.0], [-1.0, 1.0]])
DAMPING = 0.06  # 1/s, c of C = c M: three to six percent of critical
LOAD = np.array([0.0, 1.0])
SQUARES, VECTORS = eigh(STIFFNESS, MASS)
FREQUENCIES, MODES = np.sqrt(SQUARES), VECTORS.T
RATIOS = DAMPING / (2.0 * FREQUENCIES)
DAMPED = FREQUENCIES[0] * np.sqrt(1.0 - RATIOS[0] ** 2)
PULL = np.array([1.0, 0.5])  # another one
SIGNALS = [
    {"chirp": {"first": 0.3, "last": 2.0, "duration": 40.0, "amplitude": 0.05}},
    {"step": {"begin": 5.0, "size": 0.02, "rise": 1.0}, "pulse": {"duration": 2.0, "size": 0.1}},
]
START = np.array([0.3, 0.4])  # m, where the record begins, at rest
SAMPLES, PERIODS = 50, 12  # stored instants of a period, and how long the record is
DRIVEN = DAMPED * np.array([0.8, 1.0, 1.1])  # frequencies of a measured response


def swing(frequency: np.ndarray) -> np.ndarray:
    """|sum_k phi_k p_k/(omega_k^2 - Omega^2 + i c Omega)| (m,) of the second mass [m]."""
    compliance = SQUARES - frequency[:, None] ** 2 + 1j * DAMPING * frequency[:, None]
    return np.abs((MODES[:, 1] * (MODES @ LOAD) / compliance).sum(axis=1))


def driven() -> dict[str, xr.Variable]:
    """The steady motion under sin(Omega t), as one that was recorded with its signal."""
    omega = DRIVEN[0]
    time = 2 * np.pi / omega * np.arange(4 * SAMPLES + 1) / SAMPLES
    turn = (MODES @ LOAD) / (SQUARES - omega**2 + 1j * DAMPING * omega)
    q = np.exp(1j * omega * time[:, None]) * (turn @ MODES)  # its imaginary part
    sample, zeros = "signal_sample", np.zeros(len(time))
    return {
        "signal_time": variable(sample, time, "s", "time"),
        "signal_displacement": variable((sample, "dof"), q.imag, "m", "displacement"),
        "signal_velocity": variable((sample, "dof"), (1j * omega * q).imag, "m s-1", "velocity"),
        "signal_value": variable((sample, "delay"), np.sin(omega * time)[:, None], "1", "signal"),
        "signal_part": variable(sample, zeros, "1", "number of the recording"),
        "signal_calibrates": variable(sample, zeros, "1", "tells the strength"),
        "signal_load": variable(("delay", "dof"), LOAD[None], "N", "load"),
    }


def structure() -> xr.Dataset:
    """What experiments and methods read of a scene's structure."""
    operators = {"mass": MASS, "damping": DAMPING * MASS, "stiffness": STIFFNESS}
    entries = {}
    for name, matrix in operators.items():
        rows, columns = np.nonzero(matrix)
        for part, values in (("row", rows), ("column", columns), ("value", matrix[rows, columns])):
            entries[f"{name}_{part}"] = variable(f"{name}_entry", values, "1", name)
    dataset = xr.Dataset(
        entries
        | {
            "frequency": variable("mode", FREQUENCIES, "rad s-1", "frequencies"),
            "damping_ratio": variable("mode", RATIOS, "1", "damping ratios"),
            "mode_shape": variable(("mode", "dof"), MODES, "kg^(-1/2)", "modes"),
            "load": variable("dof", LOAD, "N", "load"),
            "driven_load": variable(("driven", "dof"), np.array([LOAD, PULL]), "N", "loads"),
            "probe_dof": variable("probe", [0, 1], "1", "watched displacement"),
            "response_frequency": variable("response", DRIVEN, "rad s-1", "of a measured curve"),
            "response_amplitude": variable("response", swing(DRIVEN), "m", "measured amplitude"),
            "response_dof": variable((), 1, "1", "displacement of the amplitude"),
            **driven(),
        },
        coords={"probe": variable("probe", np.array(["one", "two"], object), "1", "name")},
    )
    return label(dataset, "structure", scene="two", method="full_order", signals=SIGNALS)


def full_order() -> FullOrder:
    """Its steps are short enough that only a part in ten thousand of a response is lost."""
    mass, stiffness = csr_matrix(MASS), csr_matrix(STIFFNESS)
    term = Term(mass=mass, damping=DAMPING * mass, stiffness=stiffness, load=LOAD)
    root = np.sqrt(RATIOS.astype(complex) ** 2 - 1.0)
    poles = np.concatenate([FREQUENCIES * (-RATIOS + root), FREQUENCIES * (-RATIOS - root)])
    return FullOrder(
        term, np.array([0, 1]), Newmark(), 8 * SAMPLES, "equilibrium", DAMPED, poles, np.zeros(2)
    )


def rom() -> PolynomialRom:
    """Modal coordinates, all of them."""
    reach = np.concatenate([np.full(2, 10.0), 10.0 * FREQUENCIES])
    exponents = np.eye(4, dtype=np.int64)
    drift = np.zeros((4, 4))
    drift[:2, 2:], drift[2:, :2] = np.eye(2), -np.diag(SQUARES)
    drift[2:, 2:] = -DAMPING * np.eye(2)
    both = np.kron(np.eye(2), MODES.T)
    return PolynomialRom(
        reach, MODES @ MASS, reach, both * reach, exponents, drift * reach, exponents, MODES
    )


def reduced() -> Reduced:
    """The exact reduced model in the scene."""
    return Reduced(rom(), LOAD, np.array([0, 1]), DAMPED, Integrator())


def record() -> xr.Dataset:
    """The decay from rest at START, in closed form."""
    time = 2 * np.pi / DAMPED * np.arange(PERIODS * SAMPLES + 1) / SAMPLES
    pole = FREQUENCIES * (-RATIOS + 1j * np.sqrt(1.0 - RATIOS**2))
    # z = Re(b e^{s t}) with z(0) = phi' M q(0) and z'(0) = 0
    begin = MODES @ MASS @ START
    factor = begin * (1.0 + 1j * pole.real / pole.imag)
    wave = factor * np.exp(pole * time[:, None])
    q, v, a = ((wave * pole**power).real @ MODES for power in range(3))
    dims = ("time", "dof")
    dataset = xr.Dataset(
        {
            "displacement": variable(dims, q, "m", "displacement"),
            "velocity": variable(dims, v, "m s-1", "velocity"),
            "acceleration": variable(dims, a, "m s-2", "acceleration"),
            "probe_displacement": variable(("probe", "time"), q.T, "m", "at the probes"),
            "converged_displacement": variable(dims, q, "m", "displacement without errors in time"),
            "period": variable((), 2 * np.pi / DAMPED, "s", "period"),
            **outcome_variables("ok", seconds=1.0),
        },
        coords={
            "time": variable("time", time, "s", "time"),
            "probe": variable("probe", np.array(["one", "two"], object), "1", "name"),
        },
    )
    return label(dataset, "trajectory", scene="two", method="full_order")


def fitted() -> xr.Dataset:
    """The record of a fit that went well."""
    return xr.Dataset(
        {
            "outcome": variable((), "ok", "1", "fit"),
            "data_seconds": variable((), 0.5, "s", "fit"),
            "mapping_seconds": variable((), 3.0, "s", "fit"),
            "dynamics_seconds": variable((), 0.1, "s", "fit"),
        }
    )


def given(title: str = "", **answers: xr.Dataset) -> Given:
    """What experiments are given, with these answers."""
    known = {"train": record(), "test": record(), "fit": fitted()}
    return Given(structure(), SAMPLES, known | answers, title)
