"""Prescribed coordinates of poses, and the starts of straight lines to them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from kinetostatics.math.arrays import Array, Mask
from kinetostatics.math.rotations import Orientation


@dataclass(frozen=True)
class PrescribedCoordinates:
    """Prescribed coordinates, in addition to the closure of loops.

    Attributes:
        columns: prescribed freedoms of the tree (driven joints of the tree).
        loops: prescribed driven loops, as indices in ``LoopEquations.loops``.
        positions: indices of prescribed coordinates among x, y, z.
        angles: indices of prescribed orientation coordinates.
        orientation: convention of the orientation coordinates.
        fixed_dofs: freedoms of the tree that remain constant.
        local_dofs: number of further freedoms that do not move the platform; steps have no component along them.

    Targets (n, N) contain columns, loops, positions and angles, in this order.
    """

    columns: tuple[int, ...] = ()
    loops: tuple[int, ...] = ()
    positions: tuple[int, ...] = ()
    angles: tuple[int, ...] = ()
    orientation: Orientation | None = None
    fixed_dofs: tuple[int, ...] = ()
    local_dofs: int = 0

    def __hash__(self) -> int:
        return self._hash

    @cached_property
    def _hash(self) -> int:
        return hash((self.columns, self.loops, self.positions, self.angles, self.orientation, self.fixed_dofs, self.local_dofs))

    @cached_property
    def size(self) -> int:
        """Number of given coordinates."""
        return self.first_angle + len(self.angles)

    @cached_property
    def first_angle(self) -> int:
        """Index of the first angle among the targets."""
        return len(self.columns) + len(self.loops) + len(self.positions)

    @cached_property
    def unknown_angles(self) -> tuple[int, ...]:
        """Indices of the orientation coordinates that are unknown; empty if no orientation coordinate is prescribed."""
        return tuple(k for k in range(3) if k not in self.angles) if self.angles else ()


def for_each(array: Array, N: int) -> Array:
    """Return a copy (k, N) of an array for one pose or for N poses."""
    return np.array(array, subok=True) if array.shape[1] == N else np.repeat(array, N, axis=1)


def line_start(
    prescribed: PrescribedCoordinates, origin: tuple[Array, Array], target: Array, shorter: bool | Mask
) -> tuple[Array, Array]:
    """Return the prescribed coordinates (n, N) and all orientation coordinates (3, N) at the starts of lines to targets.

    They are those of ``origin``, except for full turns of the platform if the ``shorter`` line is taken, and except for two
    rotations with coincident axes, of which only the sum is determined.
    """
    first, c = (for_each(array, target.shape[1]) for array in origin)
    if prescribed.angles and prescribed.orientation is not None:
        if shorter is False and prescribed.orientation.is_unique(origin[1]):  # recorded code uses the general case
            return first, c
        given = list(prescribed.angles)
        aim = np.array(c, subok=True)
        aim[given] = target[prescribed.first_angle :]
        c = prescribed.orientation.same(c, np.where(np.isfinite(aim), aim, c), always=shorter)
        first[prescribed.first_angle :] = c[given]
    return first, c
