"""Which coordinates of a pose are given."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

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
    The targets are (n, N): columns, loops, positions, angles in that order.
    """

    columns: tuple[int, ...] = ()
    loops: tuple[int, ...] = ()
    positions: tuple[int, ...] = ()
    angles: tuple[int, ...] = ()
    orientation: Orientation | None = None
    fixed_dofs: tuple[int, ...] = ()

    def __hash__(self) -> int:
        return self._hash

    @cached_property
    def _hash(self) -> int:
        return hash((self.columns, self.loops, self.positions, self.angles, self.orientation, self.fixed_dofs))

    @property
    def size(self) -> int:
        """Number of given coordinates."""
        return self.first_angle + len(self.angles)

    @property
    def first_angle(self) -> int:
        """Which of the targets is the first angle."""
        return len(self.columns) + len(self.loops) + len(self.positions)

    @property
    def unknown_angles(self) -> tuple[int, ...]:
        """The orientation coordinates that the solver has to find, if any are given."""
        return tuple(k for k in range(3) if k not in self.angles) if self.angles else ()
