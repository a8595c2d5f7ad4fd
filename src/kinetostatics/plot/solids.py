"""Polygons in three dimensions: surfaces over a grid, and the outside of the cells of a grid."""

from __future__ import annotations

import numpy as np
from mpl_toolkits.mplot3d.art3d import Poly3DCollection
from numpy.typing import NDArray

from kinetostatics.math.arrays import Array

#: From where the light comes, and how much of a face's colour does not depend on it.
LIGHT = np.array([-0.35, -0.55, 0.76])
AMBIENT = 0.72


def grid_quads(points: Array) -> Array:
    """Return the quadrilaterals (m, 4, 3) between points (nx, ny, 3) of a grid; those with a NaN corner are left out."""
    corners = np.stack([points[:-1, :-1], points[1:, :-1], points[1:, 1:], points[:-1, 1:]], axis=2)
    quads = corners.reshape(-1, 4, points.shape[-1])
    return quads[np.isfinite(quads).all(axis=(1, 2))]


def cells_of(good: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return the cells (nx − 1, ny − 1, nz − 1) of a grid of nodes all of whose eight corners are good."""
    for axis in range(3):
        low = good.take(range(good.shape[axis] - 1), axis)
        good = low & good.take(range(1, good.shape[axis]), axis)
    return good


def outer_faces(cells: NDArray[np.bool_]) -> NDArray[np.intp]:
    """Return the outer faces of the cells, as nodes (m, 4, 3) of the grid."""
    found = []
    for axis in range(3):
        padding = [(1, 1) if k == axis else (0, 0) for k in range(3)]
        steps = np.diff(np.pad(cells, padding).astype(np.int8), axis=axis)
        first = np.argwhere(steps != 0)
        across, up = np.eye(3, dtype=np.intp)[[k for k in range(3) if k != axis]]
        found.append(first[:, None] + np.stack([0 * across, across, across + up, up]))
    return np.concatenate(found)


def faces(quads: Array, colours: Array, scale: Array, edge: float, label: str) -> Poly3DCollection:
    """Return faces (m, 4, 3) with RGBA colours (m, 4), darker where they turn away from the light, whichever side is seen.

    Args:
        quads: corners.
        colours: of the faces.
        scale: (3,) lengths of the axes' box, so that the light sees what the figure shows.
        edge: how dark their edges are.
        label: of the collection.
    """
    normals = np.cross((quads[:, 2] - quads[:, 0]) / scale, (quads[:, 3] - quads[:, 1]) / scale)
    size = np.linalg.norm(normals, axis=1)
    brightness = AMBIENT + (1 - AMBIENT) * np.abs(normals @ LIGHT) / np.where(size > 0, size, 1)
    lit = np.column_stack([colours[:, :3] * brightness[:, None], colours[:, 3]])
    return Poly3DCollection(list(quads), facecolors=lit, edgecolors=(0, 0, 0, edge), linewidths=0.2, label=label, zorder=3)
