"""The coefficients of Dormand and Prince's method of order 8(5,3), as SciPy has them.

    A (16, 16), C (16,)    of twelve stages, the rate at the end of the step, three more stages
    E5, E3 (13,)           of the two error estimates
    D (4, 16)              of the interpolant

Read from their file alone: the package that it lies in takes a fifth of a second to import, longer
than most models take for a decay.
"""

from pathlib import Path
from runpy import run_path

import scipy

_FOUND = run_path(str(Path(scipy.__file__).parent / "integrate/_ivp/dop853_coefficients.py"))
A, C, E5, E3, D = (_FOUND[name] for name in ("A", "C", "E5", "E3", "D"))
STAGES: int = _FOUND["N_STAGES"]
