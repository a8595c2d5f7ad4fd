"""Results of one chunk of poses: outputs by name, and the equilibrium by NumPy for all other quantities."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from kinetostatics.math.arrays import Array, Index, Mask
from kinetostatics.quantities import OF_EQUILIBRIUM
from kinetostatics.robot import Robot
from kinetostatics.statics.solution import Solution

if TYPE_CHECKING:
    from kinetostatics.engine.pose_code import PoseCode

#: Largest number of poses for which all quickly computed outputs are computed together.
_FEW = 512


class Chunk:
    """N poses that have been analysed.

    Attributes:
        robot: the robot.
        solutions: the equilibria of consecutive parts of the chunk; a pose at which a limb has another rank is a part of its own.
        sources: names of the contributions to the twist.
    """

    def __init__(self, robot: Robot, solutions: Sequence[Solution]) -> None:
        self.robot, self.solutions, self.sources = robot, tuple(solutions), solutions[0].sources

    def __getitem__(self, name: str) -> Array:
        """Return an output (…, N), see :data:`kinetostatics.quantities.OF_EQUILIBRIUM`."""
        found = [OF_EQUILIBRIUM[name](self.robot.statics, solution) for solution in self.solutions]
        return np.asarray(found[0] if len(found) == 1 else np.concatenate(found, axis=-1))

    @property
    def buckles(self) -> Mask:
        """The mask (N,) of poses at which the robot buckles."""
        return np.concatenate([self.robot.members.buckles(solution) for solution in self.solutions])

    def __reduce__(self) -> tuple[object, ...]:
        return Chunk, (self.robot, self.solutions)


class CompiledChunk(Chunk):
    """Results by compiled code, and by NumPy at poses where the record is invalid or the rank of a limb may differ."""

    def __init__(
        self,
        robot: Robot,
        sources: tuple[str, ...],
        code: PoseCode,
        stability: Callable[[], PoseCode | None],
        given: Sequence[Array],
        solve: Callable[[slice | Index], Sequence[Solution]],
    ) -> None:
        """Compute the first outputs, and find the poses to be solved by NumPy.

        Args:
            robot, sources: see :class:`Chunk`.
            code, stability: the compiled analysis, and a function that returns the compiled sufficient condition for stability.
            given: inputs of the code: coordinates, load, gravity and loads on links.
            solve: solves given poses by NumPy.
        """
        self.robot, self.sources, self._code, self._given, self._solve = robot, sources, code, given, solve
        self._stability = stability
        self._stage, self._found = -1, (np.empty((0, 0)), np.empty((0, 0), dtype=bool))
        by_numpy = self._computed("doubtful", int(given[0].shape[1] <= _FEW))
        by_numpy = by_numpy | ~self._found[1][0]
        if by_numpy.any():
            by_numpy &= np.all(np.isfinite(given[0]), axis=0)  # unreached poses are NaN
        self._which = np.flatnonzero(by_numpy)
        self._by_numpy = Chunk(robot, solve(self._which)) if self._which.size else None

    def _computed(self, name: str, least: int = 0) -> Array:
        """Return an output (…, N) of the compiled code; if not known yet, all outputs up to its stage are computed.

        Args:
            name: name of the output.
            least: smallest stage to be computed.
        """
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
        """The mask (N,) of poses at which the robot buckles, computed only where the sufficient condition for stability fails."""
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
