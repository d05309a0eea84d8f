"""Abaqus input files: nodes, elements, node sets and element sets of one part. What else they say
(materials, steps) is passed over. Source: Abaqus Keywords Reference Guide.
"""

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from vibrom.bodies.files.content import SHAPES, Content, Unreadable

# What an element's type begins with, and its number of nodes -> its kind.
FAMILIES = {
    ("C3D", 4): "tetra",
    ("C3D", 10): "tetra10",
    ("C3D", 8): "hexahedron",
    ("C3D", 20): "hexahedron20",
    ("C3D", 27): "hexahedron27",
    ("C3D", 6): "wedge",
    **{
        (family, nodes): kind
        for family in ("CPS", "CPE", "S", "STRI", "SFM3D", "M3D", "R3D", "DS")
        for nodes, kind in ((3, "triangle"), (6, "triangle6"), (4, "quad"), (8, "quad8"))
    },
    **{(family, 2): "line" for family in ("T3D", "T2D", "B", "R2D")},
    **{(family, 3): "line3" for family in ("T3D", "T2D", "B")},
}
TYPE = re.compile(r"(C3D|CPS|CPE|STRI|SFM3D|M3D|R3D|DS|T3D|T2D|B2|B3|R2D|S)(\d+)")


def read(path: Path) -> Content:
    """See `files.read`."""
    parts, points, tags = 0, [], []
    elements: dict[str, tuple[list, list]] = {}  # kind -> numbers, and tags of nodes
    sets: dict[tuple[str, str], list[int]] = {}
    for keyword, options, lines in _blocks(path):
        if keyword == "PART":
            parts += 1
        elif keyword == "NODE":
            rows = [[float(word) for word in _words(line)] for line in lines]
            tags += [int(row[0]) for row in rows]
            points += [(row[1:4] + [0.0, 0.0])[:3] for row in rows]
        elif keyword == "ELEMENT":
            kind = _kind(options["TYPE"])
            numbers, nodes = elements.setdefault(kind, ([], []))
            rows = _rows(lines, 1 + _nodes(kind))
            numbers += [row[0] for row in rows]
            nodes += [row[1:] for row in rows]
            if "ELSET" in options:
                sets.setdefault(("ELSET", options["ELSET"]), []).extend(row[0] for row in rows)
        elif keyword in ("NSET", "ELSET"):
            members = sets.setdefault((keyword, options[keyword]), [])
            members += _members(lines, "GENERATE" in options, sets, keyword)
        elif keyword == "INCLUDE":
            raise Unreadable("it includes another file; write it as one")
    if parts > 1:
        raise Unreadable(f"it has {parts} parts; export the one that is the body")
    if not tags or not elements:
        raise Unreadable("it has no *NODE or no *ELEMENT; export the mesh itself")
    return _content(np.array(tags), np.array(points), elements, sets)


def _blocks(path: Path) -> Iterator[tuple[str, dict[str, str], list[str]]]:
    """Keyword, its options, and the lines below."""
    keyword, options, lines = "", {}, []
    for line in path.read_text(encoding="utf-8", errors="replace").splitlines():
        line = line.strip()
        if line.startswith("**") or not line:
            continue
        if not line.startswith("*"):
            lines.append(line)
            continue
        yield keyword, options, lines
        keyword, *rest = _words(line[1:])
        pairs = (word.partition("=") for word in rest)
        options = {name.strip().upper(): value.strip().strip('"') for name, _, value in pairs}
        keyword, lines = keyword.upper(), []
    yield keyword, options, lines


def _words(line: str) -> list[str]:
    return [word.strip() for word in line.split(",") if word.strip()]


def _kind(word: str) -> str:
    found = TYPE.match(word.upper())
    family, nodes = found.groups() if found else ("", "0")
    if family in ("B2", "B3"):  # B21, B32: the second digit counts
        family, nodes = "B", str(int(nodes) + 1)
    kind = FAMILIES.get((family, int(nodes)))
    if kind is None:
        raise Unreadable(f"its elements of type {word} are none of a plane or solid body")
    return kind


def _nodes(kind: str) -> int:
    digits = re.search(r"\d+$", kind)
    return int(digits[0]) if digits else SHAPES[kind][1]


def _rows(lines: list[str], length: int) -> list[list[int]]:
    """Rows of so many numbers, which may go on in the next line."""
    numbers = [int(word) for line in lines for word in _words(line)]
    return [numbers[first : first + length] for first in range(0, len(numbers), length)]


def _members(lines: list[str], generate: bool, sets: dict, keyword: str) -> list[int]:
    found: list[int] = []
    for line in lines:
        words = _words(line)
        if generate:
            first, last, step = (*map(int, words), 1)[:3]
            found += range(first, last + 1, step)
            continue
        for word in words:
            found += [int(word)] if word.isdigit() else sets[keyword, word]
    return found


def _content(tags: np.ndarray, points: np.ndarray, elements: dict, sets: dict) -> Content:
    content, place = Content(points), {tag: number for number, tag in enumerate(tags.tolist())}
    for kind, (numbers, nodes) in elements.items():
        rows = np.array([[place[tag] for tag in row] for row in nodes])
        content.elements[kind] = [rows]
        row_of = {number: row for row, number in enumerate(numbers)}
        for (keyword, name), members in sets.items():
            some = [row_of[member] for member in members if member in row_of]
            if keyword == "ELSET" and some:
                corners = rows[some, : SHAPES[kind][1]]
                content.groups.setdefault(name, []).append(corners)
    for (keyword, name), members in sets.items():
        if keyword == "NSET":
            nodes = np.array([[place[tag]] for tag in members])
            content.groups.setdefault(name, []).append(nodes)
    return content
