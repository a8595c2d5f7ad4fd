"""Arrays of a result: arrays (*dims, N) of chunks of poses are joined to read-only arrays (…, *dims), NaN without results.

An output is an array of :data:`kinetostatics.quantities.OF_EQUILIBRIUM`.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Self, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinetostatics.arguments import finite_numbers, warn
from kinetostatics.exceptions import ArgumentError
from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.layout.mapping import ResultMapping
from kinetostatics.math.arrays import Array, Index, Mask, batch_first, frozen, in_threads
from kinetostatics.math.screws import Kind, move
from kinetostatics.quantities import OF_EQUILIBRIUM, QUANTITIES
from kinetostatics.robot import Robot
from kinetostatics.statics.solution import Solution
from kinetostatics.unit_hints import point_hint

if TYPE_CHECKING:
    from kinetostatics.engine.pose_code import PoseCode


@dataclass(frozen=True, eq=False)
class Batch:
    """The N poses of a result: the batch ``shape``, and ``valid`` (N,), True at poses with results."""

    shape: tuple[int, ...]
    valid: NDArray[np.bool_]

    def public(self, chunks: Sequence[Array]) -> Array:
        """Join arrays (*dims, n) of chunks, together N poses, to an array (…, *dims); NaN at poses without results."""
        if len(chunks) == 1 and not self.shape:
            return batch_first(chunks[0] if self.valid[0] else np.full_like(chunks[0], np.nan), ())
        inner = chunks[0].shape[:-1]
        result = np.empty((len(self.valid), *inner))
        at = 0
        for chunk in chunks:
            n = chunk.shape[-1]
            result[at : at + n] = chunk.transpose(chunk.ndim - 1, *range(chunk.ndim - 1))
            at += n
        if not np.all(self.valid):
            result[~self.valid] = np.nan
        return frozen(result.reshape(self.shape + inner))

    def by_contribution(self, contribution_names: Sequence[str], chunks: Sequence[Array]) -> Mapping[str, Array]:
        """Join arrays (*dims, S, n) for S contributions to an array (…, *dims) for each contribution."""
        whole = self.public(chunks)
        return ResultMapping({name: whole[..., k] for k, name in enumerate(contribution_names)})


#: Up to this number of poses, compiled code computes all outputs in its first run; for more, the twist first.
_FEW = 512


class Chunk:
    """N poses that have been analysed.

    Attributes:
        robot: the robot.
        solutions: the equilibria, in the order of the poses; a pose where a limb has an unusual rank is solved separately.
        contribution_names: names of the contributions to the twist.
    """

    def __init__(self, robot: Robot, solutions: Sequence[Solution]) -> None:
        self.robot, self.solutions, self.contribution_names = robot, tuple(solutions), solutions[0].contributions

    def __getitem__(self, name: str) -> Array:
        """(*dims, N) output of this name."""
        found = [OF_EQUILIBRIUM[name](self.robot.statics, solution) for solution in self.solutions]
        return np.asanyarray(found[0] if len(found) == 1 else np.concatenate(found, axis=-1))

    @property
    def buckles(self) -> Mask:
        return np.concatenate([self.robot.members.buckles(solution) for solution in self.solutions])

    def __reduce__(self) -> tuple[object, ...]:
        return Chunk, (self.robot, self.solutions)


class CompiledChunk(Chunk):
    """N poses analysed by compiled code; NumPy solves poses where this code is not valid or the rank of a limb may be unusual."""

    def __init__(
        self,
        robot: Robot,
        contribution_names: tuple[str, ...],
        code: PoseCode,
        stability: Callable[[], PoseCode | None],
        given: Sequence[Array],
        solve: Callable[[slice | Index], Sequence[Solution]],
    ) -> None:
        """Run at least the first stage of the compiled code, and find the poses to be solved by NumPy.

        Args:
            robot, contribution_names: see :class:`Chunk`.
            code: the compiled analysis.
            stability: function that returns the compiled sufficient condition for stability; None if there is none.
            given: inputs of the code (…, N): coordinates, load, gravity, loads on links.
            solve: function that solves some of the poses by NumPy.
        """
        self.robot, self.contribution_names, self._code, self._given, self._solve = robot, contribution_names, code, given, solve
        self._stability = stability
        self._stage, self._found = -1, (np.empty((0, 0)), np.empty((0, 0), dtype=bool))
        by_numpy = self._computed("doubtful", int(given[0].shape[1] <= _FEW))
        by_numpy = by_numpy | ~self._found[1][0]
        if by_numpy.any():
            by_numpy &= np.all(np.isfinite(given[0]), axis=0)  # unreached poses are NaN
        self._which = np.flatnonzero(by_numpy)
        self._by_numpy = Chunk(robot, solve(self._which)) if self._which.size else None

    def _computed(self, name: str, least: int = 0) -> Array:
        """(*dims, N) output of the compiled code, which runs up to this output's stage, or up to ``least`` if this is later."""
        place = self._code.places[name]
        if (stage := max(place.stage, least)) > self._stage:
            self._found, self._stage = self._code.computed(*self._given, stage=stage), stage
        return np.asarray(place.of(*self._found))

    @cached_property
    def solutions(self) -> tuple[Solution, ...]:  # type: ignore[override]
        """The equilibrium of all poses, by NumPy."""
        return tuple(self._solve(slice(None)))

    def __getitem__(self, name: str) -> Array:
        found = self._computed(name)
        if self._by_numpy is not None:
            found = np.array(found)
            found[..., self._which] = self._by_numpy[name]
        return found

    @property
    def buckles(self) -> Mask:
        """(N,) True where the robot buckles; this is computed only where the sufficient condition for stability fails."""
        code = self._stability()
        if code is None:
            return super().buckles
        _, (holds, stable) = code.computed(*self._given)
        unsure = ~(holds & stable) & np.all(np.isfinite(self._given[0]), axis=0)
        unsure[self._which] = True
        where = np.flatnonzero(unsure)
        found: Mask = np.zeros(unsure.shape, dtype=bool)
        if where.size:
            found[where] = Chunk(self.robot, self._solve(where)).buckles
        return found


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
        shape: batch shape of the configuration, broadcast against loads and gravity.
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
        """Return the result about another reference point, without checks: (3,) from o in platform axes [m]; None: o."""
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
    def contribution_names(self) -> tuple[str, ...]:
        """Names of the contributions to the twist."""
        return self.chunks[0].contribution_names

    @cached_property
    def _valid(self) -> NDArray[np.bool_]:
        return self._reached & ~self._flags("singular")

    @cached_property
    def _batch(self) -> Batch:
        return Batch(self.shape, self._valid)

    def _of_chunks(self, pick: Callable[[Chunk], Found]) -> list[Found]:
        """Return ``pick(chunk)`` of every chunk, computed in threads if the code is compiled."""
        return in_threads(pick, self.chunks, isinstance(self.chunks[0], CompiledChunk))

    def _flags(self, name: str) -> NDArray[np.bool_]:
        """(N,) output of this name, a truth value."""
        return np.concatenate(self._of_chunks(lambda chunk: chunk[name])).astype(bool)

    def _fact(self, name: str) -> NDArray[np.bool_]:
        """(…) output of this name, a truth value; False at poses without results."""
        return self._truth(self._valid & self._flags(name))

    def _truth(self, flat: NDArray[np.bool_]) -> NDArray[np.bool_]:
        found = flat.reshape(self.shape)
        found.setflags(write=False)
        return found

    def _of(self, name: str) -> Array:
        """(…, *dims) output of this name, at the reference point."""
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
        """Return the rows of an output along the first of ``dims``, by their labels, at the reference point."""
        rows = np.moveaxis(self._of(name), len(self.shape), 0)
        return ResultMapping({label: rows[k, ...] for k, label in enumerate(labels)})


# ---- reference points ------------------------------------------------------------------------------------------------


def point_name(tool: object) -> str:
    return "o" if tool is None else "the tool's tip"


def point_of_platform(what: str, point: ArrayLike) -> Array:
    """Return a point (3,) of the platform, from o in its axes [m].

    Raises:
        ArgumentError: the value is not a point.
    """
    array = finite_numbers(what, point)
    if array.shape != (3,):
        raise ArgumentError(f"{what} is {point!r}; it must be three numbers [m], from o in the platform's axes")
    return frozen(array)


def point_on_robot(what: str, point: ArrayLike, robot: Robot) -> Array:
    """Return a point as :func:`point_of_platform` does, with a warning if it is probably in mm.

    ``what`` is the name of the point in messages.
    """
    place = point_of_platform(what, point)
    for hint in point_hint(what, place, robot.zero_size):
        warn(hint)
    return place


def tool_on_robot(tool: ArrayLike | None, robot: Robot) -> Array | None:
    """Return ``tool`` checked by :func:`point_on_robot`; None without a tool."""
    return None if tool is None else point_on_robot("tool", tool, robot)
