"""What was recorded, from a file:  u(t) = c u_file(t + begin),  linear between its samples and zero
beyond them.

The acceleration of a base or the force of a hammer: a column of text, or an array of a NumPy,
MATLAB or netCDF file, named as the file has it.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vibrom.artefacts.files import DataError
from vibrom.config.digest import digest
from vibrom.config.kinds import DataFile, NonNegative, Positive
from vibrom.recordings.files import array, read
from vibrom.signals import SignalError


@dataclass(frozen=True)
class File:
    path: DataFile  # .csv, .txt, .npy, .npz, .mat or .nc, beside the scene's file
    value: str | None = None  # column or array of u; none: the last one
    time: str | None = None  # that of the instants [s]; none: the first one
    step: Positive | None = None  # s, between samples of a file without instants
    scale: float = 1.0  # c, to the load's unit
    begin: NonNegative = 0.0  # s, into the recording, where the motion begins
    digest: str = ""  # of the file; left out, that of the file as it is

    def at(self, t: np.ndarray) -> np.ndarray:
        instants, values = self._samples()
        return self.scale * np.interp(t + self.begin, instants, values, left=0.0, right=0.0)

    def _samples(self) -> tuple[np.ndarray, np.ndarray]:
        where = f"signal.file.path = {self.path!r}"
        try:
            names = list(read(self.path))
            value = array(self.path, self.value or names[-1]).ravel()
            if self.step is None:
                time = array(self.path, self.time or names[0]).ravel()
            else:
                time = self.step * np.arange(len(value))
        except DataError as error:
            raise SignalError(f"{where}: {error}") from error
        if self.digest and self.digest != digest(Path(self.path)):
            raise SignalError(f"{where} has changed since this run began; run it again")
        if self.step is None and len(names) == 1 and self.time is None:
            raise SignalError(f"{where} has no instants; give step, or a column of them")
        if len(time) != len(value):
            cure = "name columns of one length"
            raise SignalError(f"{where}: {len(time)} instants and {len(value)} values; {cure}")
        gaps = ~(np.isfinite(time) & np.isfinite(value))
        if gaps.any():
            place = int(np.argmax(gaps)) + 1
            raise SignalError(f"{where} has no number in sample {place}; fill it in or cut it off")
        if len(time) < 2 or (np.diff(time) <= 0.0).any():
            raise SignalError(f"{where}: its instants do not rise; name the column of the time")
        return time, value
