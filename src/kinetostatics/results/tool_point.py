"""Points of the platform other than o, such as the tip of a tool."""

from __future__ import annotations

from numpy.typing import ArrayLike

from kinetostatics.arguments import finite_numbers, warn
from kinetostatics.exceptions import ArgumentError
from kinetostatics.math.arrays import Array, frozen
from kinetostatics.robot import Robot
from kinetostatics.unit_hints import point_hint


def point_name(tool: object) -> str:
    """Return the name of the reference point in sentences: "the tool's tip", or "o" without a tool."""
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

    Args:
        what: name of the point in messages.
        point: (3,) from o in the platform's axes [m].
        robot: the robot.
    """
    place = point_of_platform(what, point)
    for hint in point_hint(what, place, robot.zero_size):
        warn(hint)
    return place


def tool_on_robot(tool: ArrayLike | None, robot: Robot) -> Array | None:
    """Return the point given as ``tool``, as :func:`point_on_robot` does, or None."""
    return None if tool is None else point_on_robot("tool", tool, robot)
