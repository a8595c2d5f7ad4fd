"""Frames of many poses, computed on first use."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property

from kinetostatics.math.arrays import Array, Index
from kinetostatics.mechanism.tree import Frames


class LaterFrames(Frames):
    """Frames of poses, computed on first use.

    Attributes:
        x: (nq', N) coordinates, shared with the poses: a correction of the poses changes the frames as well.
    """

    x: Array

    def __init__(self, x: Array, place: Callable[[Array], Frames]) -> None:
        vars(self).update(x=x, _place=place)

    @cached_property
    def known(self) -> Frames:
        """The computed frames."""
        place: Callable[[Array], Frames] = vars(self)["_place"]
        return place(self.x)

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
        return self.known.take(poses) if "known" in vars(self) else LaterFrames(self.x[:, poses], vars(self)["_place"])

    def put(self, poses: Index, others: Frames) -> None:
        """Replace the frames of some poses; nothing is to be done before the first use, since the coordinates have changed
        already.
        """
        if "known" in vars(self):
            self.known.put(poses, others)

    def __reduce__(self) -> tuple[object, ...]:
        """Copy and pickle the computed frames."""
        return Frames, (self.known.rotation, self.known.position)
