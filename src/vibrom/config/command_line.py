"""Overlays as a command line names them.

Snakemake reads the files behind `--configfile` before any rule of the workflow, and ends in its own
traceback where one is not there or is no YAML that it knows. The profiles ask here first.
"""

import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

from vibrom.config import files
from vibrom.config.errors import SettingsError

OPTIONS = ("--configfile", "--configfiles")


def check(words: Sequence[str]) -> None:
    """Ends the process with one line where an overlay among these words of a command cannot be
    read.
    """
    for path in overlays(words):
        try:
            files.read(path)
        except SettingsError as error:
            sys.exit(f"vibrom: {error}")


def overlays(words: Sequence[str]) -> Iterator[Path]:
    """The files: all words after the option up to the next one, or what is joined to it by '='."""
    inside = False
    for word in words:
        option, joined, value = word.partition("=")
        if word.startswith("-"):
            inside = option in OPTIONS
            if inside and joined:
                yield Path(value)
        elif inside:
            yield Path(word)
