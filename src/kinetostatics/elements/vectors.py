"""Points and directions that are fixed in bodies of equal limbs."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from kinetostatics.math.arrays import Array, Index, zeros_for
from kinetostatics.mechanism.tree import Frames


class FixedVectors:
    """Points or directions (3,), or axes (3, 3), fixed in bodies, for the k members of each of g limbs."""

    def __init__(self, rows: Sequence[Sequence[tuple[int, Array]]], shape: tuple[int, ...] = (3,)) -> None:
        g, k = len(rows), len(rows[0])
        self._shape = (*shape, k, g)
        self._bodies = np.array([body for row in rows for body, _ in row], dtype=np.intp).reshape(g, k).T.ravel()
        vectors = np.array([vector for row in rows for _, vector in row], dtype=float).reshape(g, k, *shape)
        self._vectors = np.moveaxis(vectors, (0, 1), (-1, -2)).reshape(*shape, k * g)

    def points(self, frames: Frames) -> Array:
        """Return points in the world (3, k, g, N) [m]."""
        return self._shaped(frames.points, frames)

    def at(self, frames: Frames) -> Array:
        """Return directions (3, k, g, N) or axes (3, 3, k, g, N) in the world."""
        return self._shaped(frames.directions if self._vectors.ndim == 2 else frames.orientations, frames)

    def _shaped(self, evaluate: Callable[[Index, Array], Array], frames: Frames) -> Array:
        N = frames.position.shape[2]
        if not self._bodies.size:  # avoid indexing
            return zeros_for((*self._shape, N), frames.position)
        return evaluate(self._bodies, self._vectors).reshape(*self._shape, N)
