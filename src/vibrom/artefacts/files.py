"""Files that are written whole or not at all, whoever else writes them at the same time."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


class DataError(ValueError):
    """A dataset or file that breaks the contract; the message names the file and the cure."""


@contextmanager
def replacing(path: str | Path, size: int = 0) -> Iterator[Path]:
    """A new file beside `path` that takes its place when the block ends well.

    Each writer has a file of its own, which is on the disk before it is renamed: a reader sees the
    old content or the new one. Raises DataError where it cannot be written; `size` [bytes], about
    what is written, tells a full disk from other errors, as HDF5 has an error of its own for it.
    """
    target = Path(path)
    target.parent.mkdir(parents=True, exist_ok=True)
    partial: Path | None = None
    try:
        handle, name = tempfile.mkstemp(
            prefix=f".{target.name}.", suffix=".partial", dir=target.parent
        )
        os.close(handle)
        partial = Path(name)
        partial.chmod(0o666 & ~_umask())
        yield partial
        with partial.open("rb") as written:
            os.fsync(written.fileno())
        os.replace(partial, target)
    except (OSError, RuntimeError) as error:
        full = shutil.disk_usage(target.parent).free < size
        why = "no space left on the disk" if full else str(error)
        raise DataError(
            f"{path}: cannot be written ({why}); free space or choose another results folder, "
            "then run again"
        ) from error
    finally:
        if partial is not None:
            partial.unlink(missing_ok=True)


def _umask() -> int:
    """The permissions that new files of this process lack."""
    mask = os.umask(0)
    os.umask(mask)
    return mask


def write(path: str | Path, content: bytes | str) -> None:
    """All of the file, or leave it as it was."""
    data = content.encode() if isinstance(content, str) else content
    with replacing(path, len(data)) as partial:
        partial.write_bytes(data)
