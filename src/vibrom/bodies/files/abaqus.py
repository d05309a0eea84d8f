"""Abaqus input files: nodes, elements, sets and surfaces of one part. What else they say, materials
and where an assembly puts the part among it, is passed over.

Source: Abaqus Keywords Reference Guide; Abaqus Elements Guide (faces).
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from vibrom.bodies.files.content import SHAPES, Content, Unreadable, foreign_to

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
# Corners of the faces S1, S2, ... of an element, by its dimension and number of corners.
SIDES = {
    (2, 3): ((0, 1), (1, 2), (2, 0)),
    (2, 4): ((0, 1), (1, 2), (2, 3), (3, 0)),
    (3, 4): ((0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0)),
    (3, 6): ((0, 1, 2), (3, 5, 4), (0, 3, 4, 1), (1, 4, 5, 2), (2, 5, 3, 0)),
    (3, 8): (
        (0, 1, 2, 3),
        (4, 7, 6, 5),
        (0, 4, 5, 1),
        (1, 5, 6, 2),
        (2, 6, 7, 3),
        (3, 7, 4, 0),
    ),
}
READ = ("NODE", "ELEMENT", "NSET", "ELSET", "SURFACE")
# Blocks that make nodes or elements, or say in which coordinates nodes are given.
NOT_FOLLOWED = ("NGEN", "NFILL", "NCOPY", "NMAP", "ELGEN", "ELCOPY", "SYSTEM")
TYPE = re.compile(r"(C3D|CPS|CPE|STRI|SFM3D|M3D|R3D|DS|T3D|T2D|B2|B3|R2D|S)(\d+)")


@dataclass
class Model:
    """What a file has said so far. Names of sets are one in capitals and small letters."""

    place: dict[int, list[float]] = field(default_factory=dict)  # number -> coordinates
    # kind -> number -> numbers of nodes
    elements: dict[str, dict[int, list[int]]] = field(default_factory=dict)
    sets: dict[tuple[str, str], list[int]] = field(default_factory=dict)  # NSET or ELSET, NAME
    facets: dict[str, list[list[int]]] = field(default_factory=dict)  # of a surface, nodes
    words: dict[str, str] = field(default_factory=dict)  # NAME -> as it is first written

    def set_of(self, keyword: str, name: str) -> list[int]:
        """The members of a set, to be added to."""
        self.words.setdefault(name.upper(), name)
        return self.sets.setdefault((keyword, name.upper()), [])

    def members(self, keyword: str, word: str) -> list[int]:
        """Of a set that another names, or the one that a number names."""
        if word.isdigit():
            return [int(word)]
        if (keyword, word.upper()) not in self.sets:
            raise Unreadable(f"it names a set {word!r} that is not there before; export it again")
        return self.sets[keyword, word.upper()]

    def found(self, number: int) -> tuple[str, list[int]]:
        """The kind and the nodes of an element."""
        for kind, known in self.elements.items():
            if number in known:
                return kind, known[number]
        raise Unreadable(f"it names an element {number} that is not there; export it again")


def read(path: Path) -> Content:
    """See `files.read`."""
    count, model = {"PART": 0, "INSTANCE": 0}, Model()
    for keyword, options, lines in _blocks(path):
        if keyword in count:
            count[keyword] += 1
        elif keyword == "INCLUDE" or keyword in READ and "INPUT" in options:
            raise Unreadable("it includes another file; write it as one")
        elif keyword in NOT_FOLLOWED:
            raise Unreadable(
                f"it has *{keyword}; export it with all nodes and elements written out"
            )
        elif keyword == "NODE":
            _add_nodes(model, options, lines)
        elif keyword == "ELEMENT":
            _add_elements(model, options, lines)
        elif keyword in ("NSET", "ELSET"):
            _add_members(model, keyword, options, lines)
        elif keyword == "SURFACE" and "NAME" in options:
            _add_surface(model, options, lines)
    for keyword, found in count.items():
        if found > 1:
            what = f"{found} {keyword.lower()}s"
            raise Unreadable(f"it has {what}; export the one that is the body")
    if not model.place or not model.elements:
        raise Unreadable("it has no *NODE or no *ELEMENT; export the mesh itself")
    return _content(model)


def _blocks(path: Path) -> Iterator[tuple[str, dict[str, str], list[str]]]:
    """Keyword, its options, and the lines below."""
    keyword, options, lines, begun = "", {}, [], ""
    for line in path.read_text(encoding="utf-8-sig", errors="replace").splitlines():
        if line.startswith("**") or not line.strip():
            continue
        line, begun = begun + line.strip(), ""
        if line.startswith("*") and line.endswith(","):
            begun = line  # goes on in the next one
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
        raise Unreadable(foreign_to(word))
    return kind


def _nodes(kind: str) -> int:
    digits = re.search(r"\d+$", kind)
    return int(digits[0]) if digits else SHAPES[kind][1]


def _rows(lines: list[str], length: int) -> list[list[int]]:
    """Rows of so many numbers, which may go on in the next line."""
    numbers = [int(word) for line in lines for word in _words(line)]
    if len(numbers) % length:
        raise Unreadable(
            f"its elements of {length - 1} nodes have {len(numbers)} numbers in all, no multiple "
            f"of {length}; export it again"
        )
    return [numbers[first : first + length] for first in range(0, len(numbers), length)]


def _once(known: dict, number: int, value: list, what: str) -> None:
    if known.setdefault(number, value) != value:
        raise Unreadable(f"it has two {what} with the number {number}; number them anew")


def _add_nodes(model: Model, options: dict[str, str], lines: list[str]) -> None:
    if options.get("SYSTEM", "R").upper() != "R":
        raise Unreadable("its nodes are not in rectangular coordinates; export them in those")
    rows = [[float(word.upper().replace("D", "E")) for word in _words(line)] for line in lines]
    for row in rows:
        _once(model.place, int(row[0]), (row[1:4] + [0.0, 0.0])[:3], "nodes")
    if "NSET" in options:
        model.set_of("NSET", options["NSET"]).extend(int(row[0]) for row in rows)


def _add_elements(model: Model, options: dict[str, str], lines: list[str]) -> None:
    kind = _kind(options["TYPE"])
    rows = _rows(lines, 1 + _nodes(kind))
    for row in rows:
        _once(model.elements.setdefault(kind, {}), row[0], row[1:], "elements")
    if "ELSET" in options:
        model.set_of("ELSET", options["ELSET"]).extend(row[0] for row in rows)


def _add_members(model: Model, keyword: str, options: dict[str, str], lines: list[str]) -> None:
    found: list[int] = []
    if keyword == "NSET" and "ELSET" in options:
        for number in model.members("ELSET", options["ELSET"]):
            found += model.found(number)[1]
    for line in lines:
        words = _words(line)
        if "GENERATE" in options:
            first, last, step = (*map(int, words), 1)[:3]
            found += range(first, last + 1, step)
            continue
        for word in words:
            found += model.members(keyword, word)
    model.set_of(keyword, options[keyword]).extend(found)


def _add_surface(model: Model, options: dict[str, str], lines: list[str]) -> None:
    """Faces of elements, each a set or an element and a face; or nodes."""
    name = options["NAME"]
    if options.get("TYPE", "").upper() == "NODE":
        for line in lines:
            model.set_of("NSET", name).extend(model.members("NSET", _words(line)[0]))
        return
    found = model.facets.setdefault(name.upper(), [])
    model.words.setdefault(name.upper(), name)
    for line in lines:
        of, *face = _words(line)
        for number in model.members("ELSET", of):
            kind, nodes = model.found(number)
            sides, which = SIDES.get(SHAPES[kind], ()), face[0].upper() if face else ""
            if which not in [f"S{k}" for k in range(1, len(sides) + 1)]:
                raise Unreadable(
                    f"its surface {name} names no face of its elements (S1 to S{len(sides)})"
                )
            found.append([nodes[corner] for corner in sides[int(which[1:]) - 1]])


def _content(model: Model) -> Content:
    row_of = {number: row for row, number in enumerate(model.place)}

    def rows(numbers: list) -> np.ndarray:
        try:
            return np.array([[row_of[number] for number in some] for some in numbers])
        except KeyError as error:
            raise Unreadable(f"it names a node {error} that is not there") from error

    content = Content(np.array(list(model.place.values())))
    groups: dict[str, list[np.ndarray]] = {}
    for kind, known in model.elements.items():
        content.elements[kind] = [rows(list(known.values()))]
        for (keyword, name), members in model.sets.items():
            some = [known[member] for member in members if member in known]
            if keyword == "ELSET" and some:
                groups.setdefault(name, []).append(rows(some)[:, : SHAPES[kind][1]])
    for (keyword, name), members in model.sets.items():
        if keyword == "NSET" and members:
            groups.setdefault(name, []).append(rows([[member] for member in members]))
    for name, facets in model.facets.items():
        for corners in sorted({len(facet) for facet in facets}):
            some = [facet for facet in facets if len(facet) == corners]
            groups.setdefault(name, []).append(rows(some))
    content.groups = {model.words[name]: parts for name, parts in groups.items()}
    return content
