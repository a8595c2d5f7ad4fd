"""Poses at the coordinates of a plan."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from kinetostatics.configuration import Configuration
    from kinetostatics.robot import Robot
    from kinetostatics.workspace.plan import Plan


def assemble(plan: Plan, robot: Robot, values: Mapping[str, Any], near: Configuration | None = None) -> Configuration:
    """Return the poses (N,) at coordinates, along a line from the zero pose or from ``near``."""
    given: dict[str, Any] = {plan.kind: values}
    if plan.kind == "platform":
        given["orientation"] = plan.orientation
    return robot.assemble(**given, near=near, tolerance=plan.tolerance, on_failure="nan")
