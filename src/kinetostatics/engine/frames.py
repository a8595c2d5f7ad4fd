"""Frames of many poses that are computed when they are asked for: compiled code takes them in blocks, which stay in the cache."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import Protocol

import numpy as np

from kinetostatics.engine.code import BLOCK, blocks, side_by_side
from kinetostatics.math.arrays import Array, Index
from kinetostatics.mechanism.tree import Frames


class Placed(Protocol):
    """Where coordinates put everything."""

    @property
    def frames(self) -> Frames:
        """Of all bodies."""


class Placing(Protocol):
    """What knows where coordinates (nq', N) put everything."""

    def place(self, x: Array, /) -> Placed:
        """Return it."""

    def frames_in_blocks(self, x: Array) -> tuple[Array, Array, Callable[[slice], None]]:
        """See :meth:`LaterFrames.in_blocks`."""


class LaterFrames(Frames):
    """Frames of more than ``2 * BLOCK`` poses, which are computed when they are asked for; compiled code takes them in blocks.

    Attributes:
        x: (nq', N) coordinates, side by side, which are the poses' own: what corrects the poses moves the frames as well.
    """

    x: Array

    def __init__(self, x: Array, solver: Placing) -> None:
        vars(self).update(x=x, _solver=solver)

    def in_blocks(self) -> tuple[Array, Array, Callable[[slice], None]]:
        """Return arrays for rotations (9 B, BLOCK) and positions (3 B, BLOCK), and what writes those of some poses there."""
        solver: Placing = vars(self)["_solver"]
        return solver.frames_in_blocks(self.x)

    @cached_property
    def known(self) -> Frames:
        """The same, computed."""
        *arrays, write = self.in_blocks()
        N = self.x.shape[1]
        whole = [np.empty((len(array), N)) for array in arrays]
        for part in blocks(N):
            write(part)
            for all_poses, block in zip(whole, arrays, strict=True):
                all_poses[:, part] = block
        return Frames(whole[0].reshape(3, 3, -1, N), whole[1].reshape(3, -1, N))

    @property
    def rotation(self) -> Array:  # type: ignore[override]
        """(3, 3, B, N)."""
        return self.known.rotation

    @property
    def position(self) -> Array:  # type: ignore[override]
        """(3, B, N) [m]."""
        return self.known.position

    def take(self, poses: Index | slice) -> Frames:
        """Return some of the poses."""
        if "known" in vars(self):
            return self.known.take(poses)
        x, solver = self.x[:, poses], vars(self)["_solver"]
        few: Frames | None = solver.place(x).frames if x.shape[1] <= 2 * BLOCK else None
        return few or LaterFrames(side_by_side(x, x.shape[1]), solver)

    def put(self, poses: Index, others: Frames) -> None:
        """Do nothing if the frames are not computed yet: these poses' coordinates are changed already."""
        if "known" in vars(self):
            self.known.put(poses, others)

    def __reduce__(self) -> tuple[object, ...]:
        """Be copied and pickled as what is computed."""
        return Frames, (self.known.rotation, self.known.position)
