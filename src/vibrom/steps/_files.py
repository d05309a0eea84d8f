"""Whole files out."""

import os
from pathlib import Path

from vibrom.artefacts.data import DataError


def write(path: str | Path, content: bytes | str) -> None:
    """All of the file, or leave it as it was."""
    target = Path(path)
    target.parent.mkdir(parents=True, exist_ok=True)
    partial_file = target.with_name(f".{target.name}.partial")
    try:
        partial_file.write_bytes(content.encode() if isinstance(content, str) else content)
        os.replace(partial_file, target)
    except OSError as error:
        cure = "free space or choose another results folder, then run again"
        raise DataError(f"{path}: cannot be written ({error}); {cure}") from error
    finally:
        partial_file.unlink(missing_ok=True)
