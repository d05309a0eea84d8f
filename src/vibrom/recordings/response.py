"""A measured response curve: amplitudes at frequencies of the load, in the order of the sweep."""

from __future__ import annotations

import numpy as np

from vibrom.artefacts.files import DataError
from vibrom.config.errors import closest
from vibrom.config.recorded import Response
from vibrom.recordings import files

RADIANS = {"rad/s": 1.0, "Hz": 2.0 * np.pi}


def response(
    given: Response, names: tuple[str, ...], metres: float
) -> tuple[np.ndarray, np.ndarray, int, np.ndarray]:
    """(frequencies (k,) [rad/s], amplitudes (k,) [m], number of the channel, numbers (k,) of the
    points in the file, from one); points without a number are left out.
    """
    frequency, amplitude = (
        files.array(given.file, name).ravel() for name in (given.frequency, given.amplitude)
    )
    if len(frequency) != len(amplitude):
        raise DataError(
            f"{given.file}: {len(frequency)} frequencies and {len(amplitude)} amplitudes; name "
            "those of one curve"
        )
    known = np.isfinite(frequency) & np.isfinite(amplitude)
    if not (known.any() and (frequency[known] > 0).all() and (amplitude[known] > 0).all()):
        raise DataError(f"{given.file}: frequencies and amplitudes are positive; correct them")
    channel = names[0] if given.channel is None else given.channel
    if channel not in names:
        raise DataError(f"forcing.response.channel = {channel!r}: {closest(channel, names)}")
    omega = frequency[known] * RADIANS[given.unit]
    return omega, amplitude[known] * metres, names.index(channel), np.flatnonzero(known) + 1


def point(number: int, amplitude: np.ndarray, numbers: np.ndarray, where: str) -> int:
    """The point that calibrates, among those with amplitudes (k,); `number` counts the points of
    the file from one, 0 means that of the largest amplitude.
    """
    if number == 0:
        return int(amplitude.argmax())
    if number not in numbers:
        raise DataError(
            f"{where}: calibrate = {number} is no point with a frequency and an amplitude; choose "
            f"one of the {len(numbers)} from {numbers[0]} to {numbers[-1]}, or 0 for the largest"
        )
    return int(np.searchsorted(numbers, number))
