"""Arrays of a result: chunks of poses joined, batch axes first, read-only, about the reference point."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from copy import copy
from functools import cached_property
from typing import Self, TypeVar

import numpy as np
from numpy.typing import NDArray

from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.layout.mapping import ResultMapping
from kinetostatics.math.arrays import Array, Index, Mask, frozen
from kinetostatics.math.screws import Kind, move
from kinetostatics.math.threads import in_threads
from kinetostatics.quantities import QUANTITIES
from kinetostatics.results.batch import Batch
from kinetostatics.results.chunk import Chunk, CompiledChunk
from kinetostatics.results.tool_point import point_name
from kinetostatics.statics.solution import Solution

Found = TypeVar("Found", Array, Mask)
#: Properties that depend on the reference point.
_ABOUT_POINT = (
    *("twist", "contributions", "mechanism_contributions", "by_mechanism"),
    *("stiffness", "compliance", "second_order", "source_contributions", "part_contributions"),
)


class PoseArrays:
    """The equilibrium of a batch of poses in chunks; its quantities are returned as arrays (…, *dims).

    Attributes:
        configuration: the pose or poses.
        shape: batch shape, the configuration's broadcast against loads and gravity.
        chunks: the results of the poses, in chunks.
        point: (3,) the reference point of twists, stiffness and compliance, from o in the platform's axes [m]; None: o.
    """

    def __init__(
        self,
        configuration: Configuration,
        shape: tuple[int, ...],
        which: slice | Index,
        chunks: tuple[Chunk, ...],
        reached: NDArray[np.bool_],
    ) -> None:
        self.configuration: Configuration = configuration
        self.shape: tuple[int, ...] = shape
        self.chunks = chunks
        self.point: Array | None = None
        self._at_o: Self | None = None  # the same result about o, if the reference point is another one
        self._which, self._reached = which, reached

    def seen_from(self, tool: Array | None) -> Self:
        """Return the result about another reference point: a valid point of the platform (3,) [m], or None for o."""
        at_o = self if self._at_o is None else self._at_o
        if tool is None:
            return at_o
        found = copy(at_o)  # includes computed quantities that do not depend on the point
        for name in _ABOUT_POINT:
            found.__dict__.pop(name, None)
        found.point, found._at_o = tool, at_o
        return found

    @property
    def point_name(self) -> str:
        """The reference point in sentences: "o", or "the tool's tip"."""
        return point_name(self.point)

    @property
    def solutions(self) -> tuple[Solution, ...]:
        """The equilibrium in chunks; after compiled analyses, NumPy solves it on first use."""
        return tuple(itertools.chain.from_iterable(chunk.solutions for chunk in self.chunks))

    @property
    def sources(self) -> tuple[str, ...]:
        """Names of the contributions to the twist."""
        return self.chunks[0].sources

    @cached_property
    def _valid(self) -> NDArray[np.bool_]:
        return self._reached & ~self._any_pose("singular")

    @cached_property
    def _batch(self) -> Batch:
        return Batch(self.shape, self._valid)

    def _of_chunks(self, pick: Callable[[Chunk], Found]) -> list[Found]:
        """Return a quantity of every chunk (…, N), in threads if compiled code computes it."""
        return in_threads(pick, self.chunks, isinstance(self.chunks[0], CompiledChunk))

    def _any_pose(self, name: str) -> NDArray[np.bool_]:
        """Return a truth value of every pose (N,)."""
        return np.concatenate(self._of_chunks(lambda chunk: chunk[name])).astype(bool)

    def _fact(self, name: str) -> NDArray[np.bool_]:
        """Return a truth value of every pose (…), False at poses without results."""
        return self._truth(self._valid & self._any_pose(name))

    def _truth(self, flat: NDArray[np.bool_]) -> NDArray[np.bool_]:
        found = flat.reshape(self.shape)
        found.setflags(write=False)
        return found

    def _of(self, name: str) -> Array:
        """Return an output (…, *dims), see :data:`kinetostatics.quantities.OF_EQUILIBRIUM`."""
        values = self._batch.public(self._of_chunks(lambda chunk: chunk[name]))
        kind = QUANTITIES[name].moves_as
        return values if kind is None else self._moved(values, kind)

    def _moved(self, values: Array, kind: Kind = "twist") -> Array:
        """Transform a quantity (…, *dims) from o to the reference point."""
        if self.point is None:
            return values
        frames = self.configuration.platform_frame[..., :3, :3]
        arm = np.broadcast_to(frames @ self.point, (*self.shape, 3))
        own = values.ndim - len(self.shape) - (2 if kind in ("stiffness", "compliance") else 1)
        return frozen(move(kind, values, arm.reshape(*self.shape, *(1,) * own, 3), components_last=True))

    def _by(self, name: str, labels: Sequence[str]) -> Mapping[str, Array]:
        """Return an output at the reference point, by the labels of its first axis."""
        rows = np.moveaxis(self._of(name), len(self.shape), 0)
        return ResultMapping({label: rows[k, ...] for k, label in enumerate(labels)})
