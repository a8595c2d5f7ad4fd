"""Numbers of a robot that may be off: arguments of its file, and numbers of single parts."""

from __future__ import annotations

import fnmatch
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from kinetostatics.argument_checks import check_mapping, warn
from kinetostatics.description.robot import RobotDescription
from kinetostatics.description.units import unit
from kinetostatics.design.exact import argument
from kinetostatics.design.requirements import parse_number, typed_unit
from kinetostatics.design.variants import Variants, variants_of
from kinetostatics.exceptions import ArgumentError, near_names
from kinetostatics.functions.parameters import Parameter, parameters_of
from kinetostatics.kinematics.unit_hints import odd_tolerance
from kinetostatics.math.arrays import Array
from kinetostatics.math.screws import COMPONENTS
from kinetostatics.robot import Robot


@dataclass(frozen=True)
class Change:
    """A number of the robot's description that may be off.

    Attributes:
        parameter: the number, of one component.
        unit: of it; empty where it is not known.
        variants: the file, if it is one of its arguments.
    """

    parameter: Parameter
    unit: str
    variants: Variants | None

    @property
    def name(self) -> str:
        """Name of the number."""
        return self.parameter.name

    @property
    def value(self) -> float:
        """Its nominal value, SI."""
        return self.parameter.values[0]


def changed_description(changes: Sequence[Change], amounts: Sequence[float] | Array) -> RobotDescription:
    """Return the robot's description with all numbers off, each by its amount.

    Raises:
        RobotFileError: the file is wrong with them.
    """
    pairs = list(zip(changes, map(float, amounts), strict=True))
    arguments = {item.name: item.value + by for item, by in pairs if item.variants is not None}
    description = changes[0].parameter.description
    if arguments:
        variants = next(item.variants for item in changes if item.variants is not None)
        description = variants.robot(arguments).description
    for item, by in pairs:
        if item.variants is None:
            description = item.parameter.change(description, 0, by)
    return description


def read_changes(robot: Robot, tolerances: Mapping[str, object]) -> tuple[list[Change], Array]:
    """Return what may be off, the file's arguments first, and by how much.

    Args:
        robot: the nominal robot.
        tolerances: see :func:`kinetostatics.spread`.

    Raises:
        ArgumentError: they make no sense.
    """
    check_mapping("tolerances", tolerances, '{"rod_*.outer_diameter": "0.1mm"}')
    if not tolerances:
        raise ArgumentError('tolerances has nothing in it; it must be such as {"rod_*.outer_diameter": "0.1mm"}')
    found: dict[str, tuple[Change, float]] = {}
    for pattern, change in named_changes(robot, list(tolerances)):
        if change.name in found:
            raise ArgumentError(f"tolerances: {change.name!r} is named twice, the second time by {pattern!r}")
        given = tolerances[pattern]
        found[change.name] = change, (amount := _amount(change.name, given, change))
        if change.unit == "m" and not (isinstance(given, str) and ("%" in given or typed_unit(given))):
            for hint in odd_tolerance(change.name, amount, change.value, robot.zero_size):
                warn(hint)
    every = sorted(found.values(), key=lambda item: item[0].variants is None)
    return [item[0] for item in every], np.array([item[1] for item in every])


def named_changes(robot: Robot, patterns: Sequence[str]) -> list[tuple[str, Change]]:
    """Return the numbers of a robot that patterns name, each with its pattern.

    Args:
        robot: whose numbers they are.
        patterns: names of arguments of the robot's file and of numbers of its parts; ``*`` stands for anything.

    Raises:
        ArgumentError: a pattern names nothing, or arguments of a file that says something else than the robot is.
    """
    parts, found = numbers_of_parts(robot), []
    variants = variants_of(robot) if any("." not in name for name in patterns) else None
    known = [*parts, *(variants.numbers if variants is not None else ())]
    for pattern in patterns:
        names = fnmatch.filter(known, pattern)
        if not names:
            raise ArgumentError(f"{robot.name!r} has no parameter {pattern!r}: {near_names(pattern, known)}")
        for name in names:
            if variants is not None and name in variants.numbers:
                found.append((pattern, change_of_argument(variants, name, robot)))
            else:
                found.append((pattern, change_of_part(parts[name])))
    return found


def change_of_argument(variants: Variants, name: str, robot: Robot) -> Change:
    """Return an argument of the robot's file."""
    return Change(argument(variants, name, robot.description), variants.unit(name), variants)


def change_of_part(parameter: Parameter) -> Change:
    """Return a number of a part, of one component."""
    return Change(parameter, parameter.units[0], None)


def numbers_of_parts(robot: Robot) -> dict[str, Parameter]:
    """Return all numbers of a robot's parts by name, one by one."""
    found = {}
    for name, item in parameters_of(robot).items():
        for k, step in enumerate(item.steps):
            if step is None:
                continue
            title = name if item.shape == () else f"{name}.{COMPONENTS[k]}"
            change = partial(_component, item, k)
            found[title] = Parameter(title, (item.units[k],), (), (step,), (item.values[k],), change, item.description)
    return found


def opens_loops(name: str) -> ArgumentError:
    """Return the complaint of a number with which, a little off, loops that are closed do not close any more."""
    return ArgumentError(
        f"{name}: with it a little off the loops do not close, or the pose is lost; of an overconstrained robot, "
        "tolerances tells what such errors do, and which forces they lock in"
    )


def _component(parameter: Parameter, component: int, there: RobotDescription, _: int, by: float) -> RobotDescription:
    return parameter.change(there, component, by)


def _amount(name: str, given: object, change: Change) -> float:
    """Return a tolerance in SI.

    Raises:
        ArgumentError: it is no positive number, or of another kind than the parameter.
    """
    what = f"tolerances: {name}"
    if isinstance(given, str) and given.rstrip().endswith("%"):
        number = 0.01 * abs(change.value) * parse_number(given.rstrip()[:-1], "number", what)
        if change.value == 0:
            raise ArgumentError(f"{what} is {given!r}, and a part of a number that is zero is nothing: give it with a unit")
    elif isinstance(given, str):
        number = parse_number(given, "", what)
        typed, own = typed_unit(given), "" if change.unit == "1" else change.unit
        if typed and own and unit(typed).dimension != unit(own).dimension:
            raise ArgumentError(f"{what} is {given!r}; the parameter is in {own.replace(' ', '·')}")
        if typed and change.unit == "1":
            raise ArgumentError(f"{what} is {given!r}; the parameter has no unit")
    else:
        number = float(given) if isinstance(given, (int, float, np.number)) and not isinstance(given, bool) else math.nan
    if not 0 < number < math.inf:
        raise ArgumentError(f"{what} is {given!r}; it must be a positive number such as '0.1mm' or '2%'")
    return number
