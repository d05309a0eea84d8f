"""Gmsh's text format, versions 2.2 and 4.1: physical groups are the groups, by name or, without
one, by number. Source: Gmsh reference manual, "MSH file format".
"""

from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from vibrom.bodies.files.content import Content, Unreadable

TYPES = {
    1: "line",
    2: "triangle",
    3: "quad",
    4: "tetra",
    5: "hexahedron",
    6: "wedge",
    8: "line3",
    9: "triangle6",
    10: "quad9",
    11: "tetra10",
    12: "hexahedron27",
    15: "vertex",
    16: "quad8",
    17: "hexahedron20",
}
# Gmsh's place of each node after the corners.
_EDGES = (8, 11, 13, 9, 16, 18, 19, 17, 10, 12, 14, 15)
ORDER = {
    "tetra10": (0, 1, 2, 3, 4, 5, 6, 7, 9, 8),
    "hexahedron20": (*range(8), *_EDGES),
    "hexahedron27": (*range(8), *_EDGES, 22, 23, 21, 24, 20, 25, 26),
}


def read(path: Path) -> Content:
    """See `files.read`."""
    sections = _sections(path)
    version = sections["MeshFormat"][0].split()
    if version[1] != "0":
        raise Unreadable("it is binary; export it as text")
    names = {
        (int(dim), int(tag)): name.strip().strip('"')
        for dim, tag, name in (line.split(None, 2) for line in sections["PhysicalNames"][1:])
    }
    if version[0] == "4.1":
        return _four(sections, names)
    if version[0].startswith("2"):
        return _two(sections, names)
    raise Unreadable(f"it has version {version[0]}; export version 4.1 or 2.2")


def _sections(path: Path) -> dict[str, list[str]]:
    """Section -> its lines."""
    found: dict[str, list[str]] = defaultdict(list)
    current = None
    for line in path.read_text(encoding="utf-8", errors="replace").splitlines():
        line = line.strip()
        if line.startswith("$End"):
            current = None
        elif line.startswith("$"):
            current = found[line[1:]]
        elif current is not None and line:
            current.append(line)
    if "MeshFormat" not in found or not found["Nodes"] or not found["Elements"]:
        raise Unreadable("it has no $MeshFormat, $Nodes or $Elements; export it from Gmsh")
    return found


def _group(names: dict[tuple[int, int], str], dim: int, tag: int) -> str:
    return names.get((dim, abs(tag)), str(abs(tag)))


def _kind(number: int) -> str:
    if number not in TYPES:
        raise Unreadable(f"its elements of type {number} are not known; mesh it with order 1 or 2")
    return TYPES[number]


def _content(tags: np.ndarray, points: np.ndarray, blocks: dict[tuple, list[list[int]]]) -> Content:
    """From blocks (kind, names of groups) -> tags of nodes."""
    order = np.argsort(tags)
    content = Content(points)
    for (kind, groups), nodes in blocks.items():
        found = np.array(nodes)
        place = np.searchsorted(tags, found, sorter=order)
        if place.max(initial=0) >= len(tags) or (tags[order[place]] != found).any():
            raise Unreadable("its elements name nodes that are not there; export it again")
        found = order[place]
        content.add(kind, found[:, ORDER[kind]] if kind in ORDER else found, list(groups))
    return content


def _four(sections: dict[str, list[str]], names: dict[tuple[int, int], str]) -> Content:
    entities = _entities(sections["Entities"], names)
    lines = iter(sections["Nodes"])
    next(lines)
    tags: list[int] = []
    points: list[list[float]] = []
    for line in lines:
        count = int(line.split()[3])
        tags += [int(next(lines)) for _ in range(count)]
        points += [[float(x) for x in next(lines).split()[:3]] for _ in range(count)]
    blocks: dict[tuple, list[list[int]]] = defaultdict(list)
    lines = iter(sections["Elements"])
    next(lines)
    for line in lines:
        dim, entity, number, count = map(int, line.split())
        block = blocks[_kind(number), entities.get((dim, entity), ())]
        block += [[int(tag) for tag in next(lines).split()[1:]] for _ in range(count)]
    return _content(np.array(tags), np.array(points), blocks)


def _entities(
    section: list[str], names: dict[tuple[int, int], str]
) -> dict[tuple[int, int], tuple[str, ...]]:
    """(dimension, number) of an entity -> the names of its physical groups."""
    found: dict[tuple[int, int], tuple[str, ...]] = {}
    if not section:
        return found
    lines: Iterator[str] = iter(section)
    for dim, count in enumerate(map(int, next(lines).split())):
        before = 4 if dim == 0 else 7  # its number, and where it lies
        for _ in range(count):
            words = next(lines).split()
            groups = words[before + 1 : before + 1 + int(words[before])]
            found[dim, int(words[0])] = tuple(_group(names, dim, int(tag)) for tag in groups)
    return found


def _two(sections: dict[str, list[str]], names: dict[tuple[int, int], str]) -> Content:
    rows = [line.split() for line in sections["Nodes"][1:]]
    blocks: dict[tuple, list[list[int]]] = defaultdict(list)
    dims = {"vertex": 0, "line": 1, "line3": 1}
    for line in sections["Elements"][1:]:
        _, number, count, *rest = map(int, line.split())
        kind = _kind(number)
        plane = kind.startswith(("triangle", "quad"))
        dim = dims.get(kind, 2 if plane else 3)
        groups = (_group(names, dim, rest[0]),) if count and rest[0] else ()
        blocks[kind, groups].append(rest[count:])
    tags = np.array([int(row[0]) for row in rows])
    return _content(tags, np.array([row[1:4] for row in rows], float), blocks)
