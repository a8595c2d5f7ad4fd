"""Decimation of meshes to a number of triangles that a browser can display smoothly."""

from __future__ import annotations

import numpy as np

from kinetostatics.viewer.shapes import Surface

#: Smallest and largest number of grid cells along the longest side of the mesh.
COARSEST, FINEST = 4, 4096


def decimated(surface: Surface, most: int) -> Surface:
    """Return a surface with at most ``most`` triangles, if a grid of :data:`COARSEST` cells or a finer one allows it.

    All vertices in a cell of a grid are replaced by their mean; degenerate and duplicate triangles are removed. The finest grid
    with few enough triangles is used. The mesh need not be closed or manifold.
    """
    if len(surface.faces) <= most:
        return surface
    low, high = COARSEST, FINEST
    while high - low > max(1, low // 16):
        middle = (low + high) // 2
        low, high = (middle, high) if len(_clustered(surface, middle).faces) <= most else (low, middle)
    return _clustered(surface, low)


def _clustered(surface: Surface, cells: int) -> Surface:
    vertices = surface.vertices
    start, size = vertices.min(axis=0), float(np.ptp(vertices, axis=0).max()) or 1.0
    place = np.floor((vertices - start) * (cells / size)).astype(np.int64)
    key = (place[:, 0] * (FINEST + 1) + place[:, 1]) * (FINEST + 1) + place[:, 2]
    _, cluster = np.unique(key, return_inverse=True)
    count = np.bincount(cluster)
    means = np.column_stack([np.bincount(cluster, weights=vertices[:, c]) / count for c in range(3)])
    faces = cluster[surface.faces]
    a, b, c = faces.T
    faces = faces[(a != b) & (b != c) & (c != a)]
    _, first = np.unique(np.sort(faces, axis=1), axis=0, return_index=True)
    return Surface(means, faces[np.sort(first)])
