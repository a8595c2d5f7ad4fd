"""Polygons in three dimensions: surfaces over a grid, and surfaces of bodies."""

from __future__ import annotations

import numpy as np
from mpl_toolkits.mplot3d.art3d import Poly3DCollection
from numpy.typing import NDArray

from kinetostatics.math.arrays import Array

#: Direction towards the light, and the part of a face's brightness that is independent of it.
LIGHT = np.array([-0.35, -0.55, 0.76])
AMBIENT = 0.72


def cut_cells(points: Array, field: Array) -> Array:
    """Return the cells between points (nx, ny, 3) of a grid, clipped to the area in which a field (nx, ny) is positive.

    Returns:
        Polygons (m, 6, 3); the last corner is repeated if there are fewer.
    """
    nx, ny = field.shape
    places = [np.s_[i : nx - 1 + i, j : ny - 1 + j] for i, j in ((0, 0), (1, 0), (1, 1), (0, 1))]
    quads = np.stack([points[place] for place in places], axis=2)
    levels = np.stack([field[place] for place in places], axis=2)
    whole, some = (levels > 0).all(axis=2), (levels > 0).any(axis=2)
    found = [quads[whole][:, [0, 1, 2, 3, 3, 3]]]
    for quad, level in zip(quads[some & ~whole], levels[some & ~whole], strict=True):
        ring = []
        for k in range(4):
            near, far = level[k], level[(k + 1) % 4]
            if near > 0:
                ring.append(quad[k])
            if (near > 0) != (far > 0):
                ring.append(quad[k] + near / (near - far) * (quad[(k + 1) % 4] - quad[k]))
        found.append(np.array([ring + (6 - len(ring)) * ring[-1:]]))
    return np.concatenate(found)


def skin(points: Array, field: Array, cut: NDArray[np.bool_]) -> tuple[Array, NDArray[np.intp]]:
    """Return the zero surface of a field over a grid, with a face for each pair of neighbours of different signs.

    A corner of faces is the mean of the intersections of a cell's edges with the surface (dual contouring of the cells). Outside
    the grid, the field is negative.

    Args:
        points: (nx, ny, nz, 3) positions of the nodes; NaN where unknown.
        field: (nx, ny, nz) field, positive inside.
        cut: (nx, ny, nz) mask of removed nodes; the surface is midway between them and their neighbours.

    Returns:
        Corners (m, 4, 3) of the faces, and the indices (m, 3) of their inner nodes.
    """
    around = [(1, 1)] * 3
    field = np.pad(np.where(cut, -1.0, field), around, constant_values=-1.0)
    cut, points = np.pad(cut, around), np.pad(points, [*around, (0, 0)], "edge")
    total, count = (np.zeros((*(size - 1 for size in field.shape), last)) for last in (3, 1))
    found = []
    for axis in range(3):
        ends = [tuple(np.s_[k : k - 1 or None] if n == axis else np.s_[1:-1] for n in range(3)) for k in (0, 1)]
        (near, far), (one, two) = (field[end] for end in ends), (points[end] for end in ends)
        passes = (near > 0) != (far > 0)
        one, two = (np.where(np.isfinite(a), a, b) for a, b in ((one, two), (two, one)))
        part = np.divide(near, near - far, out=np.full(near.shape, 0.5), where=passes & ~cut[ends[0]] & ~cut[ends[1]])
        through = np.where(passes[..., None], one + part[..., None] * (two - one), 0.0)
        across, up = np.eye(3, dtype=np.intp)[[n for n in range(3) if n != axis]]
        cells = np.stack([0 * across, across, across + up, up])
        for cell in cells:
            place = tuple(np.s_[first : first + size] for first, size in zip(cell, passes.shape, strict=True))
            total[place] += through
            count[place] += passes[..., None]
        first = np.argwhere(passes)
        inside = first + np.eye(3, dtype=np.intp)[axis] * (far[passes] > 0)[:, None]
        found.append((first[:, None] + cells, inside - np.eye(3, dtype=np.intp)[axis]))
    corners, nodes = (np.concatenate(part) for part in zip(*found, strict=True))
    return (total / np.maximum(count, 1))[tuple(np.moveaxis(corners, -1, 0))], nodes


def faces(quads: Array, colours: Array, scale: Array, edge: float, label: str) -> Poly3DCollection:
    """Return a collection of faces, shaded by their angle to the light; both sides are alike.

    Args:
        quads: (m, n, 3) corners.
        colours: (m, 4) RGBA colours of the faces.
        scale: (3,) lengths of the axes' box, to which normals are scaled.
        edge: opacity of the black edges.
        label: label of the collection.
    """
    normals = np.cross((quads[:, 2] - quads[:, 0]) / scale, (quads[:, 3] - quads[:, 1]) / scale)
    size = np.linalg.norm(normals, axis=1)
    brightness = AMBIENT + (1 - AMBIENT) * np.abs(normals @ LIGHT) / np.where(size > 0, size, 1)
    lit = np.column_stack([colours[:, :3] * brightness[:, None], colours[:, 3]])
    return Poly3DCollection(list(quads), facecolors=lit, edgecolors=(0, 0, 0, edge), linewidths=0.2, label=label, zorder=3)
