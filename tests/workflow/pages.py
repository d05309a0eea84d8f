"""README and docs as text: the files that they ask for, and the commands that they show."""

import re
import shutil
from collections.abc import Container

from project_copy import ROOT

PAGES = {
    str(path.relative_to(ROOT)): path.read_text()
    for path in [
        ROOT / "README.md",
        ROOT / "CONTRIBUTING.md",
        ROOT / "config/README.md",
        *sorted((ROOT / "docs").rglob("*.md")),
        ROOT / "Snakefile",  # their comments show commands, too
        *sorted((ROOT / "config").glob("*.yaml")),
    ]
}
FENCED = re.compile(r"^ *```(\w*)\n(.*?)^ *```$", re.DOTALL | re.MULTILINE)
# `some/file.py`:  and then the file in a fenced block
FILE = re.compile(r"`([\w./]+(?:\.py|\.yaml|Snakefile))`:\n\n```\w+\n(.*?)```", re.DOTALL)
OTHERS = re.compile(r"\S+\s+#.*\(or: ([\w, ]+)\)")  # what may stand in place of the last word


def walk(name: str) -> str:
    return PAGES[f"docs/walks/{name}.md"]


def blocks(text: str, language: str) -> list[str]:
    return [block for kind, block in FENCED.findall(text) if kind == language]


def lines(block: str) -> list[str]:
    """The commands of a shell block."""
    found = []
    for line in re.sub(r" *\\\n *", " ", block).splitlines():
        command = re.sub(r"(^|\s+)#.*", "", line)
        words = OTHERS.search(line)
        more = words[1].split(", ") if words else []
        found += [command, *(f"{command.rpartition(' ')[0]} {word}" for word in more)]
    return [command for command in found if command]


def is_command(text: str, programs: Container[str]) -> bool:
    """Words that begin with a program: one of these, one that is installed, or a script."""
    first, _, more = text.partition(" ")
    return bool(more) and (first in programs or bool(shutil.which(first)) or first.endswith(".sh"))


def shown(page: str, programs: Container[str]) -> list[list[str]]:
    """What a page asks to be run: the lines of each of its shell blocks, and each text between
    backquotes that is a command; of a file, what its comments show.
    """
    text = PAGES[page]
    if page.endswith(".md"):
        found = [lines(block) for block in blocks(text, "sh")]
        text = FENCED.sub("", text)
    else:
        text = "\n".join(re.findall(r"^ *# ?(.*)$", text, re.MULTILINE))
        listed = re.findall(r"^ {2,}(\S+(?: \S+)*)", text, re.MULTILINE)
        found = [[line] for line in listed if is_command(line, programs)]
    spans = [" ".join(span.split()) for span in re.findall(r"`([^`]+)`", text)]
    return found + [[span] for span in spans if is_command(span, programs)]
