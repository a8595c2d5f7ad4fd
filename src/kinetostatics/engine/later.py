"""Solutions of many poses of which most arrays are computed when they are asked for.

Computing takes less time than writing all arrays into memory, of which the twist is a small part.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import fields
from functools import cached_property
from typing import Protocol

import numpy as np

from kinetostatics.engine.code import BLOCK, blocks, side_by_side
from kinetostatics.engine.record import AT_ONCE, AT_ONCE_OF_LIMBS, given, unbalanced
from kinetostatics.limbs.statics import LimbStatics
from kinetostatics.math.arrays import Array, Index
from kinetostatics.mechanism.tree import Frames
from kinetostatics.statics.link_loads import AppliedLoad, AppliedStatics
from kinetostatics.statics.model import RobotStatics
from kinetostatics.statics.solution import Solution

_FIELDS = {kind: frozenset(field.name for field in fields(kind)) for kind in (Solution, LimbStatics)}


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
        return _itself, (self.known,)


class _Known:
    """What a solution and its limbs know, apart from them: they need not know one another, and are gone when nobody has them."""

    def __init__(
        self, robot: RobotStatics, paths: Iterable[str], array: Callable[[str], Array], whole: Callable[[], Solution]
    ) -> None:
        self.robot, self.paths, self.array, self._whole = robot, paths, array, whole

    @cached_property
    def whole(self) -> Solution:
        """The solution with all arrays."""
        return self._whole()


class LaterSolution(Solution):
    """A solution that knows some of its arrays, and how to compute all."""

    def __init__(
        self,
        robot: RobotStatics,
        frames: Frames,
        load: Array,
        gravity: Array,
        paths: Iterable[str],
        array: Callable[[str], Array],
        whole: Callable[[], Solution],
        applied: tuple[AppliedLoad, ...] = (),
    ) -> None:
        """Take what is known.

        Args:
            robot: whose solution it is.
            frames, load, gravity: what is given.
            paths: of the arrays that are there at once.
            array: returns the array at one of them.
            whole: computes the whole solution.
            applied: loads on links.
        """
        known = _Known(robot, paths, array, whole)
        limbs = tuple([_LaterLimb(known, k) for k in range(len(robot.groups))])
        vars(self).update(given(robot, frames, load, gravity, applied), _known=known, statics=limbs)
        if not (applied or robot.description.springs):
            vars(self).update(applied=(), weights_alone=None, tangents=())

    @property
    def whole(self) -> Solution:
        """The same with all arrays."""
        known: _Known = vars(self)["_known"]
        return known.whole

    @cached_property
    def applied(self) -> tuple[AppliedStatics, ...]:  # type: ignore[override]
        """Loads on links and the springs' forces, and what they do to limbs by themselves."""
        return self.whole.applied

    @cached_property
    def weights_alone(self) -> tuple[LimbStatics, ...] | None:  # type: ignore[override]
        """The limbs without these forces."""
        return self.whole.weights_alone

    @cached_property
    def tangents(self) -> tuple[Array, ...]:  # type: ignore[override]
        """Of a robot with springs, what tells where it is unstable."""
        return self.whole.tangents

    def __getattr__(self, name: str) -> object:
        if name not in _FIELDS[Solution]:
            raise AttributeError(name)
        if name not in AT_ONCE:
            return getattr(self.whole, name)
        mine, known = vars(self), vars(self)["_known"]
        if name == "undetermined":
            mine[name] = tuple(known.array(f".{name}.{k}") for k in range(len(known.robot.groups)))
        elif name == "unbalanced":
            mine[name] = unbalanced(known.paths, known.array)
        else:
            mine[name] = known.array(f".{name}")
        return mine[name]

    def __reduce__(self) -> tuple[object, ...]:
        """Be copied and pickled as the whole solution."""
        return _itself, (self.whole,)


class _LaterLimb(LimbStatics):
    """The statics of a group of limbs, of which most is computed when it is asked for."""

    def __init__(self, known: _Known, number: int) -> None:
        vars(self).update(_known=known, _number=number)

    def __getattr__(self, name: str) -> object:
        if name not in _FIELDS[LimbStatics]:
            raise AttributeError(name)
        known, number = vars(self)["_known"], vars(self)["_number"]
        if name == "group":
            return known.robot.groups[number]
        if name in AT_ONCE_OF_LIMBS:
            return known.array(f".statics.{number}.{name}")
        return getattr(self.whole, name)

    @property
    def whole(self) -> LimbStatics:
        """The same with all arrays."""
        found: LimbStatics = vars(self)["_known"].whole.statics[vars(self)["_number"]]
        return found

    def __reduce__(self) -> tuple[object, ...]:
        return _itself, (self.whole,)


def _itself(item: Solution) -> Solution:
    return item
