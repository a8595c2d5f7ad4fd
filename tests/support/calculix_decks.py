"""Input of CalculiX for parts that Netgen has meshed with curved quadratic tetrahedra in mm, and its printed displacements."""

import subprocess

import numpy as np

_EDGES = ((0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3))  # in the order of C3D10


def solid_lines(mesh):
    """Return lines with the nodes [m] and elements of a mesh, in the sets ALL and PART."""
    points = np.array(mesh.Coordinates())
    lines = ["*NODE, NSET=ALL", *(f"{k}, {x:.12g}, {y:.12g}, {z:.12g}" for k, (x, y, z) in enumerate(points / 1000, 1))]
    lines.append("*ELEMENT, TYPE=C3D10, ELSET=PART")
    for number, element in enumerate(mesh.Elements3D(), 1):
        nodes = [point.nr for point in element.points]
        corners, middles = nodes[:4], nodes[4:]
        at = points[np.array(middles) - 1]
        ordered = []
        for first, second in _EDGES:
            middle = (points[corners[first] - 1] + points[corners[second] - 1]) / 2
            ordered.append(middles[int(np.linalg.norm(at - middle, axis=1).argmin())])
        if np.linalg.det(points[np.array(corners[1:]) - 1] - points[corners[0] - 1]) < 0:  # node 4 on the other side
            corners[1], corners[2] = corners[2], corners[1]
            ordered = [ordered[2], ordered[1], ordered[0], ordered[3], ordered[5], ordered[4]]
        lines.append(", ".join(map(str, [number, *corners, *ordered])))
    return lines


def bore_lines(mesh, name, x, y, radius):
    """Return lines with the set of the nodes on a bore along z through (x, y), in mm."""
    points = np.array(mesh.Coordinates())
    on = np.flatnonzero(np.abs(np.hypot(points[:, 0] - x, points[:, 1] - y) - radius) < 1e-3) + 1
    return [f"*NSET, NSET={name}", *(f"{number}," for number in on)]


def displacements(folder, lines, nodes):
    """Solve and return the printed displacements (steps, nodes, 3) of the ``nodes``."""
    (folder / "deck.inp").write_text("\n".join(lines) + "\n")
    subprocess.run(["ccx", "deck"], cwd=folder, check=True, capture_output=True, timeout=600)
    rows = [line.split() for line in (folder / "deck.dat").read_text().splitlines()]
    values = np.array([[float(word) for word in row[1:]] for row in rows if row and row[0] in map(str, nodes)])
    return values.reshape(-1, len(nodes), 3)
