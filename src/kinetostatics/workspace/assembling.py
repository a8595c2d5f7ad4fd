"""Poses at the coordinates of a plan."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from kinetostatics.kinematics import assembly

if TYPE_CHECKING:
    from kinetostatics.kinematics.configuration import Configuration
    from kinetostatics.robot import Robot
    from kinetostatics.workspace.plan import Plan


def assemble(plan: Plan, robot: Robot, values: Mapping[str, Any], near: Configuration | None = None) -> Configuration:
    """Return the poses (N,) at coordinates, along a line from the zero pose or from ``near``."""
    given: tuple[Any, Any, str | None] = (None, values, plan.orientation) if plan.kind == "platform" else (values, None, None)
    return assembly.assemble(robot, *given, near, plan.tolerance, "nan")  # whose coordinates have been warned of before
