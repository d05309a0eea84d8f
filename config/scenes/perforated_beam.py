"""Writes perforated_beam.msh, a beam with a round hole: what Gmsh would save as text, version 4.1.

    python config/scenes/perforated_beam.py

Triangles of second order; the sides at the hole are curved. Physical groups: `fixed` and `hole`
(lines), `tip` and `above` (points), `part` (surface).
"""

from pathlib import Path

import numpy as np

LENGTH, HEIGHT = 1.0, 0.04  # m
MIDDLE, RADIUS = 0.25, 0.012  # m, of the hole along the beam
ROWS = 2  # of quadrilaterals over the height, each of which becomes two triangles


def quadrilaterals() -> np.ndarray:
    """(m, 4, 2) corners, counter-clockwise."""
    half, found = HEIGHT / 2, []
    for first, last, count in ((0.0, MIDDLE - half, 5), (MIDDLE + half, LENGTH, 16)):
        x, y = np.linspace(first, last, count + 1), np.linspace(0.0, HEIGHT, ROWS + 1)
        for i in range(count):
            for j in range(ROWS):
                found.append(
                    [(x[i], y[j]), (x[i + 1], y[j]), (x[i + 1], y[j + 1]), (x[i], y[j + 1])]
                )
    # Around the hole, from the square's side to the circle.
    side = np.linspace(-half, half, ROWS + 1)
    square = [(-half, y) for y in side[::-1]] + [(x, -half) for x in side[1:]]
    square += [(half, y) for y in side[1:]] + [(x, half) for x in side[::-1][1:]]
    outer = np.array(square)  # counter-clockwise, closed
    inner = RADIUS * outer / np.linalg.norm(outer, axis=1)[:, None]
    centre = np.array([MIDDLE, half])
    for k in range(len(outer) - 1):
        corners = outer[k], outer[k + 1], inner[k + 1], inner[k]
        found.append([corner + centre for corner in corners])
    return np.array(found)


class Nodes:
    """Numbers of points, from one on."""

    def __init__(self):
        self.number: dict[tuple, int] = {}

    def __call__(self, point) -> int:
        """The number of a point."""
        key = tuple(float(x) for x in np.round(point, 12) + 0.0)
        return self.number.setdefault(key, len(self.number) + 1)


def on_hole(*points) -> bool:
    """Do they all lie on the circle?"""
    away = [np.hypot(x - MIDDLE, y - HEIGHT / 2) for x, y in points]
    return bool(np.allclose(away, RADIUS, rtol=0, atol=1e-9))


def middle(a, b) -> np.ndarray:
    """Of a side: on the circle where both ends are."""
    point = 0.5 * (np.asarray(a) + np.asarray(b))
    if not on_hole(a, b):
        return point
    centre = np.array([MIDDLE, HEIGHT / 2])
    away = point - centre
    return centre + RADIUS * away / np.linalg.norm(away)


def main() -> None:
    """Write the file beside this one."""
    node, triangles, lines = Nodes(), [], {"fixed": [], "hole": []}
    for number, (a, b, c, d) in enumerate(quadrilaterals()):
        split = ((a, b, c), (a, c, d)) if number % 2 else ((a, b, d), (b, c, d))
        for corners in split:
            sides = [(corners[k], corners[(k + 1) % 3]) for k in range(3)]
            triangles.append([*map(node, corners), *(node(middle(*side)) for side in sides)])
            for p, q in sides:
                name = "hole" if on_hole(p, q) else "fixed" if max(p[0], q[0]) < 1e-9 else None
                if name:
                    lines[name].append([node(p), node(q), node(middle(p, q))])
    points = {
        "tip": node((LENGTH, HEIGHT / 2)),
        "above": node((0.5 * (LENGTH + MIDDLE + HEIGHT / 2), HEIGHT)),
    }
    names = [(0, 1, "tip"), (0, 2, "above"), (1, 1, "fixed"), (1, 2, "hole"), (2, 1, "part")]
    place = {number: key for key, number in node.number.items()}
    text = ["$MeshFormat", "4.1 0 8", "$EndMeshFormat", "$PhysicalNames", str(len(names))]
    text += [f'{dim} {tag} "{name}"' for dim, tag, name in names]
    text += ["$EndPhysicalNames", "$Entities", "2 2 1 0"]
    for tag, number in enumerate(points.values(), start=1):
        text.append(f"{tag} {' '.join(f'{x:.12g}' for x in place[number])} 0 1 {tag}")
    box = f"0 0 0 {LENGTH:.12g} {HEIGHT:.12g} 0"
    text += [f"{tag} {box} 1 {tag} 0" for tag in (1, 2)] + [f"1 {box} 1 1 2 1 2", "$EndEntities"]
    count = len(place)
    text += ["$Nodes", f"1 {count} 1 {count}", f"2 1 0 {count}", *map(str, range(1, count + 1))]
    text += [f"{x:.12g} {y:.12g} 0" for x, y in (place[k] for k in range(1, count + 1))]
    blocks = [(0, tag, 15, [[number]]) for tag, number in enumerate(points.values(), start=1)]
    blocks += [(1, tag, 8, rows) for tag, rows in enumerate(lines.values(), start=1)]
    blocks.append((2, 1, 9, triangles))
    total, element = sum(len(rows) for *_, rows in blocks), 0
    text += ["$EndNodes", "$Elements", f"{len(blocks)} {total} 1 {total}"]
    for dim, tag, kind, rows in blocks:
        text.append(f"{dim} {tag} {kind} {len(rows)}")
        for row in rows:
            element += 1
            text.append(" ".join(map(str, (element, *row))))
    text.append("$EndElements")
    Path(__file__).with_suffix(".msh").write_text("\n".join(text) + "\n")


if __name__ == "__main__":
    main()
