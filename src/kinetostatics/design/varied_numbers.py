"""Design variables of a robot: single numbers, or several numbers with a common value."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from kinetostatics.exceptions import ArgumentError
from kinetostatics.parametric.parametric_robot import ParametricRobot, check_unit
from kinetostatics.parametric.robot_numbers import RobotNumber
from kinetostatics.robot import Robot


@dataclass(frozen=True)
class VariedNumbers:
    """Varied numbers, and the robots with their values.

    Attributes:
        robots: the parametric robot.
        alike: numbers by name, or by a pattern such as ``rod_*.outer_diameter`` for a common value.
    """

    robots: ParametricRobot
    alike: Mapping[str, Sequence[RobotNumber]]

    def own(self, name: str) -> float:
        """Return the value in the file; for several numbers, their mean."""
        return float(np.mean([item.value for item in self.alike[name]]))

    @property
    def are_own(self) -> bool:
        """Whether all numbers of each pattern are equal in the file, so that its robot is a possible design."""
        return all(len({item.value for item in several}) == 1 for several in self.alike.values())

    def unit(self, name: str) -> str:
        """Return the SI unit of a number; empty if it has none or is uncertain."""
        found = self.alike[name][0].unit
        return "" if found == "1" else found

    def robot(self, values: Mapping[str, float]) -> Robot:
        """Return the robot with these values; expressions of the file are evaluated with them.

        Raises:
            RobotFileError: the robot is invalid with these values.
        """
        return Robot(self.robots.description({item.name: value for name, value in values.items() for item in self.alike[name]}))


def sizes_of(robots: ParametricRobot, names: Sequence[str], typed: Sequence[tuple[str, str]]) -> VariedNumbers:
    """Return the varied numbers of a robot.

    Args:
        robots: the parametric robot.
        names: names of numbers, or patterns.
        typed: names with the units of their given values.

    Raises:
        ArgumentError: a name is unknown, a number is named twice, numbers of a pattern have different units, or a value has a
            unit of another kind.
    """
    alike: dict[str, list[RobotNumber]] = {}
    for name, number in robots.select(names, "vary"):
        alike.setdefault(name, []).append(number)
    for name, several in alike.items():
        if len(units := {item.unit for item in several}) > 1:
            kinds = ", ".join(sorted(units))
            raise ArgumentError(f"vary: {name} names numbers in several units, {kinds}; numbers of one pattern have one value")
    for name, unit in typed:
        check_unit(alike[name][0], unit, "vary")
    return VariedNumbers(robots, alike)
