"""A result as it is, or as a point of the platform sees it."""

from __future__ import annotations

from kinetostatics.math.arrays import Array
from kinetostatics.results.result import Result
from kinetostatics.results.tool_point import PointResult, seen_at


def seen(result: Result, tool: Array | None) -> Result | PointResult:
    """Return what a point of the platform does, of what o does; the result itself where there is no tool.

    Args:
        result: of an analysis.
        tool: (3,) the point from o in the platform's axes [m], as :func:`point_on_robot` returns it.
    """
    if tool is None:
        return result
    rotation = result.configuration.platform_frame[..., :3, :3]
    return seen_at(tool, rotation, result.twist, result.contributions, result.stiffness, result.compliance)
