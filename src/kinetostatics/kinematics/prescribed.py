"""Prescribed coordinates of poses, and the starts of straight lines to them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from kinetostatics.math.arrays import Array, Mask
from kinetostatics.math.orientation import Orientation


@dataclass(frozen=True)
class PrescribedCoordinates:
    """Which coordinates are given, besides the closed loops.

    Attributes:
        columns: freedoms of the tree that are given (driven joints of the tree).
        loops: driven loops that are given, as numbers in ``LoopEquations.loops``.
        positions: which of x, y, z are given.
        angles: which orientation coordinates are given.
        orientation: their convention.
        fixed_dofs: freedoms of the tree along which no step goes.
        local_dofs: number of freedoms that do not move the platform; they stay as they are.
    The targets are (n, N): columns, loops, positions, angles in that order.
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
        """Which of the targets is the first angle."""
        return len(self.columns) + len(self.loops) + len(self.positions)

    @cached_property
    def unknown_angles(self) -> tuple[int, ...]:
        """The orientation coordinates that the solver has to find, if any are given."""
        return tuple(k for k in range(3) if k not in self.angles) if self.angles else ()


def for_each(array: Array, N: int) -> Array:
    """Return a copy (k, N) of an array of one pose or of N."""
    return np.array(array, subok=True) if array.shape[1] == N else np.repeat(array, N, axis=1)


def line_start(
    prescribed: PrescribedCoordinates, origin: tuple[Array, Array], target: Array, shorter: bool | Mask
) -> tuple[Array, Array]:
    """Return the prescribed coordinates (n, N) and all orientation coordinates (3, N) with which lines to targets start.

    They are those of the ``origin`` but for full turns of the platform, if the ``shorter`` way is wanted, and where the axes
    of two turns are one line, which leaves but the sum of the turns determined.
    """
    first, c = (for_each(array, target.shape[1]) for array in origin)
    if prescribed.angles and prescribed.orientation is not None:
        if shorter is False and prescribed.orientation.is_unique(origin[1]):  # a record takes the general way
            return first, c
        given = list(prescribed.angles)
        aim = np.array(c, subok=True)
        aim[given] = target[prescribed.first_angle :]
        c = prescribed.orientation.same(c, np.where(np.isfinite(aim), aim, c), always=shorter)
        first[prescribed.first_angle :] = c[given]
    return first, c
