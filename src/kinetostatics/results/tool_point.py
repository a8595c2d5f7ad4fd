"""A result as a point of the platform sees it, such as the tip of a tool."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from kinetostatics.argument_checks import Keyword, finite_numbers, warn
from kinetostatics.exceptions import ArgumentError
from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.math.arrays import Array, frozen
from kinetostatics.math.screws import Kind, move
from kinetostatics.printing.mappings import Named, ShortRepr
from kinetostatics.quantities import COMPUTED, QUANTITIES, value_at
from kinetostatics.robot import Robot
from kinetostatics.unit_hints import point_hint

#: What a point of the platform other than o is called.
TIP = "the tool's tip"


class AtO(Protocol):
    """What of a :class:`kinetostatics.Result` is about o."""

    @property
    def configuration(self) -> Configuration: ...  # noqa: D102
    @property
    def twist(self) -> Array: ...  # noqa: D102


R = TypeVar("R", bound=AtO)


@dataclass(frozen=True, eq=False, repr=False)
class PointResult(ShortRepr):
    """What a point of the platform does; made by :meth:`Result.at_point`.

    Attributes:
        point: (3,) from o in the platform's axes [m].
        arm: (…, 3) from o to the point, world axes [m].
        twist: (…, 6) displacement of the point and rotation of the platform, world axes [m, rad].
        contributions: what each adds to it (…, 6), as in :attr:`Result.contributions`.
        stiffness: (…, 6, 6) at the point, actuators locked, world axes.
        compliance: (…, 6, 6) likewise.
    """

    point: Array
    arm: Array
    twist: Array
    contributions: Mapping[str, Array]
    stiffness: Array
    compliance: Array

    def moved(self, twists: Array) -> Array:
        """Return twists (…, 6) at o as those at the point."""
        return frozen(move("twist", twists, self.arm, components_last=True))


def named_point(tool: object) -> str:
    """Return what a point of the platform is called in sentences: o, where there is no tool."""
    return "o" if tool is None else TIP


def point_of_platform(what: str, point: ArrayLike) -> Array:
    """Return a point (3,) of the platform, from o in its axes [m].

    Raises:
        ArgumentError: it is none.
    """
    array = finite_numbers(what, point)
    if array.shape != (3,):
        raise ArgumentError(f"{what} is {point!r}; it must be three numbers [m], from o in the platform's axes")
    return array


def point_on_robot(what: str, point: ArrayLike, robot: Robot) -> Array:
    """Return a point as :func:`point_of_platform`; one that looks as if it were in mm gets a warning.

    Args:
        what: its name in messages.
        point: (3,) from o in the platform's axes [m].
        robot: which it belongs to.
    """
    place = point_of_platform(what, point)
    for hint in point_hint(what, place, robot.zero_size):
        warn(hint)
    return place


def tool_on_robot(tool: ArrayLike | None, robot: Robot) -> Array | None:
    """Return the point that a function is given as ``tool``, as :func:`point_on_robot` does; None where there is none."""
    return None if tool is None else point_on_robot("tool", tool, robot)


def seen(result: R, tool: Array | None) -> R | PointResult:
    """Return a result as a point of the platform sees it; the result itself where there is no tool."""
    return result if tool is None else seen_at(result, tool)


def seen_at(result: AtO, point: Array) -> PointResult:
    """Return what a point (3,) of the platform, from o in its axes [m], does, of what o does."""
    rotation = result.configuration.platform_frame[..., :3, :3]
    arm = np.array(np.broadcast_to(rotation @ point, (*result.twist.shape[:-1], 3)))

    def moved(item: object, kind: Kind) -> object:
        if isinstance(item, Mapping):
            return Named({name: moved(part, kind) for name, part in item.items()})
        return frozen(move(kind, np.asarray(item), arm, components_last=True))

    kinds = {name: QUANTITIES[name].moves_as for name in COMPUTED}
    found: dict[str, Keyword] = {name: moved(value_at(result, name), kind) for name, kind in kinds.items() if kind is not None}
    return PointResult(frozen(point), frozen(arm), **found)
