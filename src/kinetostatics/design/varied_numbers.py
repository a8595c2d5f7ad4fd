"""Design variables of a robot: one number of it, or several numbers with one common value."""

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
    """Numbers that are varied, and the robots that they make.

    Attributes:
        robots: the robots that there may be.
        alike: numbers by name, and by patterns such as ``rod_*.outer_diameter``, of which all have one value.
    """

    robots: ParametricRobot
    alike: Mapping[str, Sequence[RobotNumber]]

    def own(self, name: str) -> float:
        """Return the file's own value; of several numbers their mean."""
        return float(np.mean([item.value for item in self.alike[name]]))

    @property
    def are_own(self) -> bool:
        """Whether the file's own robot has such values: numbers that are to be alike may not be so."""
        return all(len({item.value for item in several}) == 1 for several in self.alike.values())

    def unit(self, name: str) -> str:
        """Return the SI unit of a number, empty if it has none or that is not certain."""
        found = self.alike[name][0].unit
        return "" if found == "1" else found

    def robot(self, values: Mapping[str, float]) -> Robot:
        """Return the robot with these values; expressions of the file are evaluated with them.

        Raises:
            RobotFileError: there is no such robot.
        """
        return Robot(self.robots.description({item.name: value for name, value in values.items() for item in self.alike[name]}))


def sizes_of(robots: ParametricRobot, names: Sequence[str], typed: Sequence[tuple[str, str]]) -> VariedNumbers:
    """Return the numbers of a robot that are named.

    Args:
        robots: the robots that there may be.
        names: of its numbers, or patterns.
        typed: names, and units with which they were given.

    Raises:
        ArgumentError: there is none of a name, or a number is named twice, or numbers of several kinds are to be alike; or a
            number was given in a unit of another kind than its own.
    """
    alike: dict[str, list[RobotNumber]] = {}
    for name, number in robots.select(names, "vary"):
        alike.setdefault(name, []).append(number)
    for name, several in alike.items():
        if len(units := {item.unit for item in several}) > 1:
            kinds = ", ".join(sorted(units))
            raise ArgumentError(f"vary: {name} names numbers in several units, {kinds}; numbers of one pattern are alike")
    for name, unit in typed:
        check_unit(alike[name][0], unit, "vary")
    return VariedNumbers(robots, alike)
