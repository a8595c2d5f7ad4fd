"""What an optimization varies of a robot: arguments of its file, and numbers of single parts, of one or of several alike."""

from __future__ import annotations

import fnmatch
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from kinetostatics.description.robot import RobotDescription
from kinetostatics.description.units import unit
from kinetostatics.design.changes import numbers_of_parts
from kinetostatics.design.variants import Variants
from kinetostatics.exceptions import ArgumentError, RobotFileError, near_names
from kinetostatics.functions.parameters import Parameter
from kinetostatics.robot import Robot


@dataclass(frozen=True)
class Sizes:
    """Numbers that are varied, and the robots that they make.

    Attributes:
        variants: the file, whose arguments some of them are.
        first: the robot as the file has it.
        parts: numbers of parts by name, and by patterns such as ``rod_*.outer_diameter``, of which all have one value.
    """

    variants: Variants
    first: Robot
    parts: Mapping[str, tuple[Parameter, ...]]

    def own(self, name: str) -> float:
        """Return the file's own value; of several numbers their mean."""
        if name not in self.parts:
            return self.variants.numbers[name]
        return float(np.mean([item.values[0] for item in self.parts[name]]))

    @property
    def are_own(self) -> bool:
        """Whether the file's own robot has such values: numbers that are to be alike may not be so."""
        return all(len({item.values[0] for item in several}) == 1 for several in self.parts.values())

    def unit(self, name: str) -> str:
        """Return the SI unit of a number, empty if it has none or that is not certain."""
        if name not in self.parts:
            return self.variants.unit(name)
        found = self.parts[name][0].units[0]
        return "" if found == "1" else found

    def check_units(self, typed: Sequence[tuple[str, str]]) -> None:
        """Complain of numbers that were given in a unit of another kind than their own.

        Raises:
            ArgumentError: one was.
        """
        self.variants.check_units([(name, given) for name, given in typed if name not in self.parts])
        for name, given in ((name, given) for name, given in typed if name in self.parts):
            own = self.unit(name)
            if not own or unit(own.replace("·", " ")).dimension != unit(given).dimension:
                raise ArgumentError(f"vary: {name} is given in {given}, but it {f'is in {own}' if own else 'has no unit'}")

    def robot(self, values: Mapping[str, float]) -> Robot:
        """Return the robot with these values; what the file computes from its arguments follows them.

        Raises:
            RobotFileError: there is no such robot.
        """
        arguments = {name: value for name, value in values.items() if name not in self.parts}
        robot = self.variants.robot(arguments) if arguments else self.first
        names = [name for name in values if name in self.parts]
        if not names:
            return robot
        present = numbers_of_parts(robot) if arguments else {}
        changes = [(item, values[name] - present.get(item.name, item).values[0]) for name in names for item in self.parts[name]]
        try:
            return Robot(_changed(robot.description, changes))
        except ArgumentError as error:
            raise RobotFileError(str(error), self.variants.path) from error


def _changed(description: RobotDescription, changes: Sequence[tuple[Parameter, float]]) -> RobotDescription:
    """Return a robot with numbers changed, in an order that makes a robot at each step: a tube grows before its hole.

    Raises:
        ArgumentError: there is none.
    """
    left = list(changes)
    for _ in changes:
        put_off = []
        for parameter, by in left:
            try:
                description = parameter.change(description, 0, by)
            except ArgumentError:
                put_off.append((parameter, by))
        left = put_off
    for parameter, by in left:  # what is wrong is said
        description = parameter.change(description, 0, by)
    return description


def sizes_of(variants: Variants, names: Sequence[str]) -> Sizes:
    """Return the numbers of a robot that are named, those with a dot of its parts, the others of its file.

    Raises:
        ArgumentError: there is none of a name, or a number is named twice, or numbers of several kinds are to be alike.
    """
    variants.check([name for name in names if "." not in name])
    first = variants.robot({})
    known = numbers_of_parts(first) if any("." in name for name in names) else {}
    parts: dict[str, tuple[Parameter, ...]] = {}
    for name in (name for name in names if "." in name):
        found = fnmatch.filter(known, name)
        if not found:
            raise ArgumentError(f"vary: {first.name!r} has no {name!r} among the numbers of its parts: {near_names(name, known)}")
        if twice := {item.name for several in parts.values() for item in several} & set(found):
            raise ArgumentError(f"vary: {min(twice)!r} is varied twice, the second time as {name!r}")
        if len(units := {known[item].units for item in found}) > 1:
            kinds = ", ".join(sorted(own[0] for own in units))
            raise ArgumentError(f"vary: {name} names numbers in several units, {kinds}; numbers of one pattern are alike")
        parts[name] = tuple(known[item] for item in found)
    return Sizes(variants, first, parts)
