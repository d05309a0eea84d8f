"""Captions: a bold title and plain paragraphs of reStructuredText, the same for Snakemake's report
and for the page.
"""

import re
from typing import NamedTuple


class Caption(NamedTuple):
    title: str
    paragraphs: tuple[str, ...]


def parse(text: str, where: str) -> Caption:
    """The caption in this text; `where` is named when there is none."""
    blocks = [" ".join(block.split()) for block in re.split(r"\n\s*\n", text.strip())]
    match = re.fullmatch(r"\*\*(.+)\*\*", blocks[0]) if blocks else None
    if match is None:
        raise ValueError(
            f"{where}: a caption begins with its title as **bold** line; write one and an empty line"
        )
    return Caption(match.group(1), tuple(block.replace("``", "") for block in blocks[1:]))
