"""Solutions of many poses of which most arrays are computed when they are asked for.

Computing takes less time than writing all arrays into memory, of which the twist is a small part.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import fields
from functools import cached_property
from typing import Any

from kinetostatics.engine.record import given_and_unbalanced
from kinetostatics.limbs.statics import LimbStatics
from kinetostatics.math.arrays import Array
from kinetostatics.mechanism.tree import Frames
from kinetostatics.statics.model import RobotStatics
from kinetostatics.statics.solution import Solution

#: Arrays that are there at once, and arrays of each group of limbs.
_AT_ONCE = ("o", "twists", "platform_weight", "singular", "indeterminate", "basis_degenerate", "undetermined", "unbalanced")
_OF_LIMBS = ("doubtful", "degenerate")
_FIELDS = {kind: frozenset(field.name for field in fields(kind)) for kind in (Solution, LimbStatics)}


def is_at_once(path: str) -> bool:
    """Return whether the array at a path of :func:`kinetostatics.engine.record.arrays_of` is there at once."""
    first, *others = path.strip(".").split(".")
    return first in _AT_ONCE or (first == "statics" and others[1] in _OF_LIMBS)


class LaterSolution(Solution):
    """A solution that knows some of its arrays, and how to compute all."""

    def __init__(
        self,
        robot: RobotStatics,
        frames: Frames,
        load: Array,
        gravity: Array,
        arrays: Mapping[str, Any],
        whole: Callable[[], Solution],
    ) -> None:
        """Take what is known.

        Args:
            robot: whose solution it is.
            frames, load, gravity: what is given.
            arrays: those that are there at once, by their paths.
            whole: computes the whole solution.
        """
        groups = range(len(robot.groups))
        known: dict[str, Any] = {name: arrays[f".{name}"] for name in _AT_ONCE if f".{name}" in arrays}
        known |= given_and_unbalanced(robot, frames, load, gravity, arrays)
        known["undetermined"] = tuple(arrays[f".undetermined.{k}"] for k in groups)
        known["statics"] = tuple(_LaterLimb(self, k, arrays) for k in groups)
        if not robot.description.springs:
            known |= {"applied": (), "weights_alone": None}
        vars(self).update(known, _whole=whole, _robot=robot)

    @cached_property
    def whole(self) -> Solution:  # type: ignore[override]
        """The same with all arrays."""
        found: Solution = vars(self)["_whole"]()
        return found

    @cached_property
    def applied(self) -> Any:  # type: ignore[override]
        """The springs' forces, and what they do to limbs by themselves."""
        return self.whole.applied

    @cached_property
    def weights_alone(self) -> Any:  # type: ignore[override]
        """The limbs without these forces."""
        return self.whole.weights_alone

    def group(self, number: int) -> Any:
        """Return a group of the robot's limbs."""
        return vars(self)["_robot"].groups[number]

    def __getattr__(self, name: str) -> Any:
        if name not in _FIELDS[Solution]:
            raise AttributeError(name)
        return getattr(self.whole, name)

    def __reduce__(self) -> tuple[Any, ...]:
        """Be copied and pickled as the whole solution."""
        return _itself, (self.whole,)


class _LaterLimb(LimbStatics):
    """The statics of a group of limbs, of which most is computed when it is asked for."""

    def __init__(self, solution: LaterSolution, number: int, arrays: Mapping[str, Any]) -> None:
        known = {name: arrays[f".statics.{number}.{name}"] for name in _OF_LIMBS}
        vars(self).update(known, _solution=solution, _number=number)

    def __getattr__(self, name: str) -> Any:
        if name not in _FIELDS[LimbStatics]:
            raise AttributeError(name)
        if name == "group":
            return vars(self)["_solution"].group(vars(self)["_number"])
        return getattr(self.whole, name)

    @property
    def whole(self) -> LimbStatics:
        """The same with all arrays."""
        found: LimbStatics = vars(self)["_solution"].whole.statics[vars(self)["_number"]]
        return found

    def __reduce__(self) -> tuple[Any, ...]:
        return _itself, (self.whole,)


def _itself(item: Any) -> Any:
    return item
