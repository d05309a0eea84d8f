"""Operators of the channels that a user knows, and their modes:  K phi = omega^2 M phi."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import LinAlgError, eigh

from vibrom.artefacts.files import DataError
from vibrom.config.recorded import Operators
from vibrom.recordings import files

FAR = 2.0  # ratio of the first frequency to that of the recordings, at most


@dataclass(frozen=True)
class Known:
    """M, C, K (n, n) and the modes (k, n), mass-normalised, with frequencies (k,) [rad/s]."""

    mass: np.ndarray
    damping: np.ndarray
    stiffness: np.ndarray
    modes: np.ndarray
    frequencies: np.ndarray


def known(given: Operators, channels: int, frequency: float) -> Known:
    """Read and checked against the number of channels and their first frequency [Hz]."""
    wanted = {"mass": given.mass, "stiffness": given.stiffness, "damping": given.damping}
    found = {}
    for what, name in wanted.items():
        matrix = np.zeros((channels, channels)) if name is None else files.array(given.file, name)
        matrix = np.atleast_2d(matrix)
        if matrix.shape != (channels, channels):
            shape = " x ".join(map(str, matrix.shape))
            raise DataError(
                f"{given.file}: {name} is {shape}, but there are {channels} channels; record every "
                "displacement of the matrices, or leave `operators` out"
            )
        found[what] = matrix
    try:
        square, shapes = eigh(found["stiffness"], found["mass"])
    except LinAlgError as error:
        raise DataError(f"{given.file}: the mass is not positive definite; correct it") from error
    if square[0] <= 0.0:
        raise DataError(f"{given.file}: the stiffness is not positive definite; correct it")
    ratio = np.sqrt(square[0]) / (2.0 * np.pi * frequency)
    if max(ratio, 1.0 / ratio) > FAR:
        raise DataError(
            f"{given.file}: the first mode has {np.sqrt(square[0]) / (2 * np.pi):.4g} Hz, the "
            f"recordings {frequency:.4g} Hz; correct time_unit or the matrices"
        )
    return Known(found["mass"], found["damping"], found["stiffness"], shapes.T, np.sqrt(square))
