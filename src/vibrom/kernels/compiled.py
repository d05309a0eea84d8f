"""Compiled functions that are kept on disk, and the records that they take.

    @kernel(signature)      compiles now, or reads what an earlier process compiled
    @part, @inlined         a function that kernels call; Python may call it too
    machine_type(Record)    the signature of a named tuple, from its annotations

How lanes, kernels and their store work is told in docs/kernels.md.
"""

import inspect
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from hashlib import sha256
from pathlib import Path
from types import CodeType, FunctionType
from typing import Annotated, Any, get_args, get_origin, get_type_hints

import numpy as np
from numba import njit, types
from numba.core.errors import NumbaExperimentalFeatureWarning
from numba.extending import overload

# Arrays of a record, contiguous, the state index last.
Vector = Annotated[np.ndarray, types.float64[::1]]
Rows = Annotated[np.ndarray, types.float64[:, ::1]]
Blocks = Annotated[np.ndarray, types.float64[:, :, ::1]]
Numbers = Annotated[np.ndarray, types.int64[::1]]
Places = Annotated[np.ndarray, types.int64[:, ::1]]

# A part is called by kernels only, and counts no references, which would cost more than a small
# body's step: it may not allocate.
OPTIONS = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True, "_nrt": False}
SCALARS = {float: types.float64, int: types.int64, bool: types.boolean}


def machine_type(annotation: Any) -> types.Type:
    """The numba type of a number, of an array declared above, or of a named tuple of such."""
    if get_origin(annotation) is Annotated:
        return get_args(annotation)[1]
    if annotation in SCALARS:
        return SCALARS[annotation]
    fields = get_type_hints(annotation, include_extras=True).values()
    return types.BaseTuple.from_types([machine_type(field) for field in fields], annotation)


def part(function: Callable) -> Callable:
    """A function of which kernels are made. Numbers that are known when a kernel is compiled, as
    the number of lanes, stay known inside it.
    """
    return _part(function, OPTIONS)


def inlined(function: Callable) -> Callable:
    """A part that is copied into its kernel; needed where it takes an array on the stack, which
    stays in registers only so, and costly to compile where it is long.
    """
    return _part(function, OPTIONS | {"forceinline": True})


def _part(function: Callable, options: dict) -> Callable:
    @overload(function, strict=False, prefer_literal=True, jit_options=options)
    def implementation(*arguments, **keywords):
        return function

    return function


def kernel(*signatures, fastmath: bool | set[str] = True, nogil: bool = False):
    """Compiles a function for these signatures and keeps it on disk, so that a second process does
    not compile again; with `nogil` threads may run it at the same time.

    It is named after the numbers that it captured and after its `edition`. Without the first,
    versions for other widths that different processes compiled could carry one symbol, and a third
    process that loads both would call the wrong one; without the second an edited helper would
    stay as it was in every kernel that calls it.
    """

    def compile(function: Callable) -> Callable:
        captured = (cell.cell_contents for cell in function.__closure__ or ())
        numbers = (str(value) for value in captured if isinstance(value, int))
        name = (function.__qualname__, *numbers, edition(function, *signatures))
        function.__qualname__ = "_".join(name)
        options = {"cache": True, "fastmath": fastmath, "nogil": nogil, "error_model": "numpy"}
        try:
            return njit(list(signatures), **options)(function)
        except RuntimeError as error:
            if "cannot cache" not in str(error):
                raise
            # Neither the package's folder nor a home can be written: every process compiles.
            return njit(list(signatures), **options | {"cache": False})(function)

    return compile


@contextmanager
def passing_kernels() -> Iterator[None]:
    """Kernels are passed to kernels as pointers, which numba calls experimental at every use."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", NumbaExperimentalFeatureWarning)
        yield


def edition(function: Callable, *signatures) -> str:
    """Digest of what a kernel is made of beside its own file, which is all that numba looks at: the
    files of the functions and records that it uses, however deep, and the fields of its records.
    """
    here = Path(__file__).parent
    files = {__file__, str(here / "lanes.py"), str(here / "vector.py")}
    files |= {inspect.getfile(item) for item in _used(function, set())}
    digest = sha256(b"".join(Path(file).read_bytes() for file in sorted(files)))
    for signature in signatures:
        digest.update(repr([_fields(kind) for kind in signature.args]).encode())
    return digest.hexdigest()[:8]


def _used(function: FunctionType, seen: set) -> set:
    """Functions and named tuples that a function refers to by name or has captured, and what those
    use.
    """
    found = [function.__globals__.get(name) for name in _names(function.__code__)]
    found += [cell.cell_contents for cell in function.__closure__ or ()]
    for item in found:
        item = getattr(item, "py_func", getattr(item, "_defn", item))
        if isinstance(item, FunctionType) and item not in seen:
            seen.add(item)
            _used(item, seen)
        elif isinstance(item, type) and hasattr(item, "_fields"):
            seen.add(item)
    return seen


def _names(code: CodeType) -> Iterator[str]:
    yield from code.co_names
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _names(constant)


def _fields(kind: types.Type) -> Any:
    """Names of a record's fields, level by level."""
    if not isinstance(kind, types.BaseTuple):
        return None
    names = getattr(getattr(kind, "instance_class", None), "_fields", ())
    return names, [_fields(item) for item in kind.types]
