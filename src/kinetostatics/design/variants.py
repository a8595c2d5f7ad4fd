"""Robots of one file with other values of its xacro arguments, and the same pose of each of them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from kinetostatics.description.robot import RobotDescription
from kinetostatics.exceptions import ArgumentError, RobotFileError, near_names
from kinetostatics.files.parameter_units import check_parameter_units, parameter_unit
from kinetostatics.files.reader import parameter_values, read_robot_file
from kinetostatics.kinematics.assembly import SolverChoice, assemble
from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.robot import Robot

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

#: Fields of a description, its links, joints and loops on which neither statics nor mass depend: what is drawn, moments of
#: inertia, limits, how it was read.
IDLE = ("parameters", "file_warnings", "extra", "inertia", "lower", "upper", "cone", "effort", "velocity")


@dataclass(frozen=True)
class Variants:
    """A file, the values of its arguments that are given, and platform and base if they are named.

    Attributes:
        path: of the file.
        given: values by name; the others are the file's own.
        links: ``platform`` and ``base``, as :func:`kinetostatics.load_robot` takes them.
    """

    path: str
    given: Mapping[str, object]
    links: Mapping[str, str | None]

    @cached_property
    def numbers(self) -> dict[str, float]:
        """The values of all arguments that are numbers, in the file's order."""
        found: dict[str, float] = {}
        for name, text in parameter_values(self.path, self.given).items():
            try:
                number = float(text)
            except ValueError:
                continue
            if math.isfinite(number):
                found[name] = number
        return found

    @cached_property
    def _known(self) -> dict[tuple[tuple[str, float], ...], RobotDescription]:
        return {}

    def read(self, changes: Mapping[str, float]) -> RobotDescription:
        """Return what the file says with other values of some arguments; what was read before is kept.

        Raises:
            RobotFileError: the file is wrong with them.
        """
        key = tuple(sorted((name, value) for name, value in changes.items() if value != self.numbers[name]))
        if key not in self._known:
            self._known[key] = read_robot_file(self.path, {**self.given, **dict(key)}, **self.links)
        return self._known[key]

    def robot(self, changes: Mapping[str, float]) -> Robot:
        """Return the robot with other values of some arguments; those that the file computes from them follow.

        Raises:
            RobotFileError: the file is wrong with them.
        """
        return Robot(read_robot_file(self.path, {**self.given, **changes}, **self.links))

    def check(self, names: Sequence[str]) -> None:
        """Complain of names that are no numbers of the file.

        Raises:
            ArgumentError: one is not.
        """
        for name in names:
            if name not in self.numbers:
                known = near_names(name, self.numbers) if self.numbers else "it has none"
                raise ArgumentError(f"{self.path} has no number {name!r} among its xacro arguments: {known}")

    def check_units(self, typed: Sequence[tuple[str, str]]) -> None:
        """Complain of parameters that were given in a unit of another kind than the file's.

        Raises:
            ArgumentError: one was.
        """
        for name, unit in typed:
            check_parameter_units(self.path, {**self.given, name: self.numbers[name]}, {name: unit}, **self.links)

    def unit(self, name: str) -> str:
        """Return the SI unit of an argument, empty if it is not certain."""
        return parameter_unit(self.numbers[name], lambda value: self.read({name: value}))


def alike(one: RobotDescription, other: RobotDescription) -> bool:
    """Whether two robots differ in nothing that statics depend on."""
    for item in fields(RobotDescription):
        a, b = getattr(one, item.name), getattr(other, item.name)
        if item.name in IDLE or not item.compare or a == b:
            continue
        if not isinstance(a, Mapping) or a.keys() != b.keys() or any(_bare(a[name]) != _bare(b[name]) for name in a):
            return False
    return True


def _bare(item: DataclassInstance) -> dict[str, object]:
    return {one.name: getattr(item, one.name) for one in fields(item) if one.compare and one.name not in IDLE}


def variants_of(robot: Robot) -> Variants:
    """Return the variants of a robot that was read from a file.

    Raises:
        ArgumentError: it was not, or it was changed since.
    """
    description = robot.description
    every: list[Mapping[str, str | None]] = [{}, {"platform": description.platform, "base": description.base}]
    for links in every:
        try:
            same = read_robot_file(description.path, description.parameters, **links)
        except (ArgumentError, RobotFileError):
            continue
        if same == description:
            return Variants(description.path, description.parameters, links)
    raise ArgumentError(
        f"the robot {robot.name!r} is not what its file {description.path!r} says: parameters belong to a file; load it from "
        "there, or save it"
    )


def same_pose(configuration: Configuration, robot: Robot, loops: SolverChoice) -> Configuration:
    """Return the pose of another variant at the same coordinates: those that the pose was assembled with, or else its actuators'.

    It is followed from the pose of the first, so that the assembly mode is the same. ``loops`` says which solver does that.
    """
    near = replace(configuration, robot=robot)
    if configuration.prescribed:
        names, values, orientation = configuration.prescribed, configuration.platform, configuration.orientation.name
        given = {name: np.array(values[name]) for name in names}
        return assemble(robot, None, given, orientation, near, near.tolerance, "nan", loops)
    given = {name: np.array(value) for name, value in configuration.actuators.items()}
    return assemble(robot, given, None, None, near, near.tolerance, "nan", loops)
