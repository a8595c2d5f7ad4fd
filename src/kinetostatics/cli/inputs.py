"""Values on the command line (numbers with units, NAME=VALUE, ranges, lists), and the robot, pose and loads they describe."""

from __future__ import annotations

import argparse
import contextlib
import math
import os
import re
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING

from kinetostatics.arguments import Keyword, whole_number
from kinetostatics.cli.options import Argument
from kinetostatics.exceptions import ArgumentError, AssemblyError, KinetostaticsError
from kinetostatics.units import KINDS, KNOWN, PLATFORM_KINDS, Unit, article, find_unit, typed_number

if TYPE_CHECKING:
    from kinetostatics.description.loads import LinkLoad, Payload
    from kinetostatics.kinematics.configuration import Configuration
    from kinetostatics.robot import Robot

VALUES_HELP = """\
values:
  Numbers are SI: m, rad, N, N·m. They may carry units, with SI prefixes: z=500mm rx=-2deg, 1.5kN, 20Nm, 70GPa, 7.8g/cm3.
"""
GRID_HELP = """\
  FROM:TO:COUNT and A,B,C make a grid, whose poses are all combinations of their values.
"""

#: Largest number of values along one dimension, and of poses.
MOST = 1_000_000


def parse_quantity(text: str, kind: str | None = None) -> float:
    """Return a number in SI.

    Args:
        text: the number with an optional unit, such as ``500mm``, ``-2deg``, ``1.5kN`` or ``-1e-3``.
        kind: required kind of the unit, one of :data:`kinetostatics.units.KINDS`; "number": no unit is allowed;
            None: all units are allowed.
    """
    number = typed_number(text)
    if number is None:
        raise ArgumentError(f"{text.strip()!r} is not a number, with or without a unit; units are {KNOWN}")
    value, name = number
    if not math.isfinite(value):
        raise ArgumentError(f"{text.strip()!r} is too large")
    if not name:
        return value
    unit = find_unit(name)
    if unit is None:
        raise ArgumentError(f"{text.strip()!r} has the unknown unit {name!r}; units are {KNOWN}")
    if kind is not None and (kind == "number" or unit.kind != kind):
        expected = "a plain number" if kind == "number" else article(kind)
        given = article(unit.kind) if unit.kind else "another quantity"
        raise ArgumentError(f"{text.strip()!r} is {given}, but {expected} is needed")
    return unit.in_si(value)


def unit_of(text: str) -> Unit | None:
    """Return the unit of a number; None if the text is not a number with a known unit."""
    number = typed_number(text)
    return find_unit(number[1]) if number and number[1] else None


def parse_range(option: str, name: str, text: str, kind: str | None = None) -> tuple[float, float, int | None]:
    """Return (first value, last value, number of values or None) of a range ``FROM:TO:COUNT`` or ``FROM:TO``.

    ``option`` and ``name`` are for messages; for ``kind`` see :func:`parse_quantity`.
    """
    parts = text.split(":")
    if len(parts) not in (2, 3):
        raise ArgumentError(f"{option}: {name}={text} is not of the form {name}=FROM:TO or {name}=FROM:TO:COUNT")
    first, last = parse_coordinates(option, name, parts[:2], kind)
    if len(parts) == 2:
        return first, last, None
    if not parts[2].strip().isdecimal() or int(parts[2]) < 2:
        raise ArgumentError(f"{option}: {name}: {parts[2]!r} is not a number of values, which must be at least 2")
    if int(parts[2]) > MOST:
        count = parts[2].strip()
        raise ArgumentError(f"{option}: {name}: {count} values are too many; at most {MOST:,} go along a dimension")
    return first, last, int(parts[2])


def parse_values(option: str, name: str, text: str, kind: str | None = None) -> float | list[float]:
    """Return the number of a text, or the list of numbers of ``FROM:TO:COUNT`` or ``A,B,C``, in SI."""
    if ":" in text:
        first, last, count = parse_range(option, name, text, kind)
        if count is None:
            raise ArgumentError(f"{option}: {name}={text} does not give the number of values: {name}={text}:11")
        step = (last - first) / (count - 1)
        return [*(first + step * k for k in range(count - 1)), last]
    if "," in text:
        return parse_coordinates(option, name, text.split(","), kind)
    return parse_coordinates(option, name, [text], kind)[0]


def parse_coordinates(option: str, name: str, texts: Sequence[str], kind: str | None) -> list[float]:
    """Return the values of one coordinate or parameter in SI. Raise an ArgumentError if their units are of several kinds."""
    try:
        values = [parse_quantity(text, kind) for text in texts]
    except ArgumentError as error:
        raise ArgumentError(f"{option}: {name}: {error}") from None
    kinds = {unit.dimension: text.strip() for text in texts if (unit := unit_of(text)) is not None}
    if len(kinds) > 1:
        raise ArgumentError(f"{option}: {name}: {' and '.join(map(repr, kinds.values()))} are not of one kind")
    return values


def parse_items(option: str, items: Iterable[str]) -> dict[str, str]:
    """Return the texts of the values by name, from items ``name=value``."""
    values: dict[str, str] = {}
    for text in items:
        name, sign, value = (part.strip() for part in text.partition("="))
        if not (name and sign and value):
            raise ArgumentError(f"{option}: {text.strip()!r} is not of the form name=value")
        if name in values:
            raise ArgumentError(f"{option}: {name!r} is given twice")
        values[name] = value
    return values


def parse_parameters(items: Iterable[str]) -> dict[str, Keyword]:
    """Return the values of ``--set`` by name: a number in SI if the value has a unit, else the unchanged text."""
    values = parse_items("--set", items)
    return {name: value if unit_of(value) is None else parse_quantity(value) for name, value in values.items()}


def typed_units(items: Iterable[str]) -> dict[str, str]:
    """Return the SI unit of each value of ``--set`` that has a unit, by name."""
    units: dict[str, str] = {}
    for name, value in parse_items("--set", items).items():
        kinds = [typed.kind for part in re.split("[:,]", value) if (typed := unit_of(part)) is not None]
        if kinds and kinds[0]:
            units[name] = KINDS[kinds[0]].replace("·", " ")
    return units


def number_of(option: str, text: str, kind: str | None = "number") -> float:
    """Return the number of an option in SI; for ``kind`` see :func:`parse_quantity`."""
    try:
        return parse_quantity(text, kind)
    except ArgumentError as error:
        raise ArgumentError(f"{option}: {error}") from None


# ---- values of options ------------------------------------------------------------------------------------------------


def option_of(name: str, argument: Argument | None = None) -> str:
    """Return the option of an argument, such as ``--platform-link``; the name of a positional argument has no dashes."""
    return (argument and argument.option) or f"--{name.replace('_', '-')}"


def value_of(name: str, args: argparse.Namespace) -> Keyword:
    """Return the value of an option as an argument of the command's function; None if the option is not given."""
    argument, given = args.arguments[name], getattr(args, name)
    option = option_of(name, argument)
    if given is None or given is False or given == []:
        return None
    if argument.kind == "items":
        return parse_items(option, given)
    if argument.kind == "count":
        return _whole_number_of(option, given, argument.least)
    if argument.kind in ("", "flag", "text", "optional text", "texts", "names"):
        return given
    if argument.kind == "wrench":
        return [number_of(option, text, "force" if k < 3 else "moment") for k, text in enumerate(given)]
    if argument.size:
        return [number_of(option, text, argument.kind) for text in given]
    return number_of(option, given, argument.kind)


def _whole_number_of(option: str, text: str, least: int) -> int:
    number = math.nan
    with contextlib.suppress(ArgumentError):
        number = parse_quantity(text, "number")
    return whole_number(option, int(number) if number.is_integer() else None, least, shown=text.strip())


def given_of(names: Iterable[str], args: argparse.Namespace) -> dict[str, Keyword]:
    """Return the values of the given options by name, as :func:`value_of` returns them."""
    values = {name: value_of(name, args) for name in names}
    return {name: value for name, value in values.items() if value is not None}


# ---- the robot -------------------------------------------------------------------------------------------------------


def load_robot(args: argparse.Namespace) -> Robot:
    """Load the robot of ROBOT with ``--set``, ``--platform-link`` and ``--base-link``."""
    from kinetostatics.files.bundled import robot_path
    from kinetostatics.parametric.parametric_robot import ParametricRobot
    from kinetostatics.robot import load_robot

    path, parameters = os.fspath(robot_path(args.robot)), parse_parameters(args.parameters)
    links = {"platform_link": args.platform_link, "base_link": args.base_link}
    robot = load_robot(path, parameters, **links)
    ParametricRobot(robot, links).check_units(typed_units(args.parameters), "parameters")
    return robot


# ---- the pose ------------------------------------------------------------------------------------------------------------


def pose_of(robot: Robot, args: argparse.Namespace) -> tuple[Configuration, list[str]]:
    """Return (pose at ``--platform`` or ``--actuators``, warnings).

    Without coordinates, all actuators are at zero or, if the loops do not close there, the pose is :func:`closed_zero_pose`.
    """
    option, items = typed_pose(args)
    given = single_values(robot, option, items)
    try:
        return assembled(robot, option, given, args), []
    except AssemblyError:
        if given:
            raise
        # where the loops are open at the file's zero, the nearest closed pose is used
        warning = "the loops do not close with all actuators at zero; this is the closed pose nearest to the file's zero"
        return closed_zero_pose(robot, args), [warning]


def closed_zero_pose(robot: Robot, args: argparse.Namespace) -> Configuration:
    """Return the closed pose nearest to the file's zero."""
    return robot.configuration(robot.model_q(robot.zero_poses)[:, 0], **given_of(("closure_tolerance",), args))


def typed_pose(args: argparse.Namespace) -> tuple[str, list[str]]:
    """Return (option, items): "--actuators" if it is given, else "--platform", and its texts ``NAME=VALUE``."""
    return ("--actuators", args.actuators) if args.actuators else ("--platform", args.platform)


def grid_of(robot: Robot | None, args: argparse.Namespace) -> tuple[str, dict[str, float | list[float]]]:
    """Return (option, coordinates): "--actuators" if it is given, else "--platform", and by name its values or lists of values.

    For ``robot`` None, the kinds of actuator coordinates are not checked.
    """
    option, typed = typed_pose(args)
    items = parse_items(option, typed)
    return option, {name: parse_values(option, name, text, coordinate_kind(robot, option, name)) for name, text in items.items()}


def assembled(robot: Robot, option: str, coordinates: Mapping[str, object], args: argparse.Namespace) -> Configuration:
    """Return the poses at coordinates of ``--platform`` or ``--actuators``; without coordinates, all actuators are at zero."""
    return robot.assemble(**pose_arguments(robot, option, coordinates, args))


def pose_arguments(robot: Robot, option: str, coordinates: Mapping[str, object], args: argparse.Namespace) -> dict[str, Keyword]:
    """Return the arguments of :meth:`Robot.assemble` for poses at coordinates of ``--platform`` or ``--actuators``."""
    options: dict[str, Keyword] = given_of(("orientation", "closure_tolerance"), args)
    near = near_pose(robot, args.near, options) if args.near else None
    return {**options, "near": near, option[2:]: coordinates or None}


def near_pose(robot: Robot, near: Iterable[str], options: Mapping[str, Keyword]) -> Configuration:
    """Return the pose of ``--near``; ``options`` are further arguments of :meth:`Robot.assemble`."""
    items = parse_items("--near", near)
    of = "platform" if all(name in PLATFORM_KINDS for name in items) else "actuators"
    start = single_values(robot, f"--{of}", near, "--near")
    if any(name in robot.description.joints and name not in robot.description.actuated for name in items):
        from kinetostatics.kinematics.alternatives import closed_near

        return robot.configuration(robot.model_q(closed_near(robot, start))[:, 0])
    try:
        return robot.assemble(**{**options, of: start})
    except KinetostaticsError as error:
        raise ArgumentError(f"--near: {error}") from error


def single_values(robot: Robot, option: str, items: Iterable[str], typed: str | None = None) -> dict[str, float]:
    """Return the value of each coordinate in SI, by name, from items ``NAME=VALUE``. Raise an ArgumentError for ranges and lists.

    ``option``: "--platform" or "--actuators", whose coordinates are given. ``typed``: the option in messages.
    """
    typed = typed or option
    texts = parse_items(typed, items)
    return {name: parse_coordinates(typed, name, [text], coordinate_kind(robot, option, name))[0] for name, text in texts.items()}


def coordinate_kind(robot: Robot | None, option: str, name: str) -> str | None:
    """Return the kind of a coordinate of ``--platform`` or ``--actuators``: "length", "angle", or None if unknown."""
    if option == "--platform":
        return PLATFORM_KINDS.get(name)
    connection = None if robot is None else robot.mechanism.connections.get(name)
    return None if connection is None else connection.type.kind  # assemble() will list the names


def swept_coordinates(robot: Robot, args: argparse.Namespace) -> tuple[str, dict[str, str], dict[str, float]]:
    """Return (option, varied, constant) for a command with ``--sweep``.

    ``option``: the option for constant coordinates, "--platform" or "--actuators". ``varied``: texts of the coordinates in
    ``--sweep``, by name. ``constant``: values of the coordinates in ``option``, by name [m, rad].
    """
    swept = parse_items("--sweep", args.sweep)
    actuators = [name for name in swept if name in robot.description.actuated]
    if actuators and len(actuators) < len(swept):
        raise ArgumentError("--sweep: coordinates of actuators and of the platform cannot vary together")
    option, other = ("--actuators", "platform") if actuators else ("--platform", "actuators")
    if getattr(args, other):
        raise ArgumentError(f"--sweep: the coordinates that do not vary are given by {option}")
    return option, swept, single_values(robot, option, getattr(args, option[2:]))


# ---- loads ---------------------------------------------------------------------------------------------------------------


def loads_of(args: argparse.Namespace) -> dict[str, Keyword]:
    """Return the loads on the command line as arguments of :func:`kinetostatics.analyze`."""
    return given_of(("load", "point", "frame", "gravity"), args) | link_loads_of(args) | payload_of(args)


def link_loads_of(args: argparse.Namespace) -> dict[str, Keyword]:
    """Return the loads on links on the command line as an argument of :func:`kinetostatics.analyze`; without any, no argument."""
    loads: dict[str, list[LinkLoad]] = {}
    for link, *texts in args.load_on:
        loads.setdefault(link, []).append(_link_load(link, texts))
    return {"loads": loads} if loads else {}


def payload_of(args: argparse.Namespace) -> dict[str, Keyword]:
    """Return the payload on the command line as an argument of :func:`kinetostatics.analyze`; without payload, no argument."""
    mass, center = value_of("payload", args), value_of("payload_center", args)
    if mass is not None:
        return {"payload": placed_payload(mass, args)}
    if center is not None or args.payload_link is not None:
        option = "--payload-link" if center is None else "--payload-center"
        raise ArgumentError(f"{option} gives the position of a payload, but its mass is missing: --payload 5kg")
    return {}


def placed_payload(mass: float, args: argparse.Namespace) -> Payload:
    """Return a payload with the centre and link on the command line."""
    from kinetostatics.description.loads import Payload

    return Payload(mass, tuple(value_of("payload_center", args) or (0.0, 0.0, 0.0)), link=args.payload_link)


def _link_load(link: str, texts: list[str]) -> LinkLoad:
    """Return one load of ``--load-on``; ``texts`` follow the link's name."""
    from kinetostatics.description.loads import LinkLoad

    frame = texts.pop() if texts[-1:] in (["link"], ["world"]) else "world"
    if len(texts) not in (6, 9):
        raise ArgumentError(
            f"--load-on {link}: there are {len(texts)} numbers; give FX FY FZ MX MY MZ, then X Y Z if the force does not act "
            "at the link's origin"
        )
    kinds = ["force"] * 3 + ["moment"] * 3 + ["length"] * 3
    numbers = [number_of(f"--load-on {link}", text, kind) for text, kind in zip(texts, kinds, strict=False)]
    return LinkLoad(tuple(numbers[:6]), tuple(numbers[6:]) or (0.0, 0.0, 0.0), frame)
