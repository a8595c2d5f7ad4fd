"""The robot, the pose and the loads of a command line."""

from __future__ import annotations

import argparse
import os
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

from kinetostatics.arguments import Keyword
from kinetostatics.cli.typed_values import (
    given_of,
    number_of,
    parse_coordinates,
    parse_items,
    parse_parameters,
    parse_values,
    typed_units,
    value_of,
)
from kinetostatics.description.units import PLATFORM_KINDS
from kinetostatics.exceptions import ArgumentError, AssemblyError, KinetostaticsError

if TYPE_CHECKING:
    from kinetostatics.description.loads import LinkLoad
    from kinetostatics.kinematics.configuration import Configuration
    from kinetostatics.robot import Robot


def load_robot(args: argparse.Namespace) -> Robot:
    """Return the robot of ROBOT, ``--set``, ``--platform-link`` and ``--base-link``."""
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
    """Return the pose of ``--platform`` or ``--actuators``, and warnings."""
    option, items = typed_pose(args)
    given = single_values(robot, option, items)
    try:
        return assembled(robot, option, given, args), []
    except AssemblyError:
        if given:
            raise
        # if the zero of the file is no pose, the nearest closed pose is used
        q = robot.model_q(robot.zero_poses)[:, 0]
        pose = robot.configuration(q, **given_of(("closure_tolerance",), args))
        return pose, ["the loops do not close with all actuators at zero; this is the closed pose nearest to the file's zero"]


def typed_pose(args: argparse.Namespace) -> tuple[str, list[str]]:
    """Return "--platform" or "--actuators", and its items."""
    return ("--actuators", args.actuators) if args.actuators else ("--platform", args.platform)


def grid_of(robot: Robot | None, args: argparse.Namespace) -> tuple[str, dict[str, float | list[float]]]:
    """Return "--platform" or "--actuators", and its coordinates: values, or lists of values for a grid.

    ``robot`` decides whether an actuator coordinate is a length or an angle.
    """
    option, typed = typed_pose(args)
    items = parse_items(option, typed)
    return option, {name: parse_values(option, name, text, coordinate_kind(robot, option, name)) for name, text in items.items()}


def assembled(robot: Robot, option: str, coordinates: Mapping[str, object], args: argparse.Namespace) -> Configuration:
    """Return the poses at the coordinates of ``--platform`` or ``--actuators``; default: the zero pose."""
    return robot.assemble(**where_of(robot, option, coordinates, args))


def where_of(robot: Robot, option: str, coordinates: Mapping[str, object], args: argparse.Namespace) -> dict[str, Keyword]:
    """Return the arguments of :meth:`Robot.assemble` for coordinates of ``--platform`` or ``--actuators``."""
    options: dict[str, Keyword] = given_of(("orientation", "closure_tolerance"), args)
    near = near_pose(robot, args.near, options) if args.near else None
    return {**options, "near": near, option[2:]: coordinates or None}


def near_pose(robot: Robot, near: Iterable[str], options: Mapping[str, Keyword]) -> Configuration:
    """Return the pose of ``--near``; ``options`` are other arguments of :meth:`Robot.assemble`."""
    items = parse_items("--near", near)
    of = "platform" if all(name in PLATFORM_KINDS for name in items) else "actuators"
    start = single_values(robot, f"--{of}", near, "--near")
    if any(name in robot.description.joints and name not in robot.description.driven for name in items):
        from kinetostatics.kinematics.alternatives import closed_near

        return robot.configuration(robot.model_q(closed_near(robot, start))[:, 0])
    try:
        return robot.assemble(**{**options, of: start})
    except KinetostaticsError as error:
        raise ArgumentError(f"--near: {error}") from error


def single_values(robot: Robot, option: str, items: Iterable[str], typed: str | None = None) -> dict[str, float]:
    """Return the value of each coordinate, by name, for options that take one value of each.

    Args:
        robot: the robot.
        option: ``--platform`` or ``--actuators``: the kind of the coordinates.
        items: texts ``NAME=VALUE``.
        typed: the option that was typed, for messages; the same by default.
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
    """Return the coordinates of ``--sweep`` and the constant ones.

    Returns:
        Their common option, "--platform" or "--actuators"; the varied ones, as texts; and the constant ones [m, rad].
    """
    swept = parse_items("--sweep", args.sweep)
    actuators = [name for name in swept if name in robot.description.driven]
    if actuators and len(actuators) < len(swept):
        raise ArgumentError("--sweep: coordinates of actuators and of the platform cannot vary together")
    option, other = ("--actuators", "platform") if actuators else ("--platform", "actuators")
    if getattr(args, other):
        raise ArgumentError(f"--sweep: the coordinates that do not vary are given by {option}")
    return option, swept, single_values(robot, option, getattr(args, option[2:]))


# ---- loads ---------------------------------------------------------------------------------------------------------------


def loads_of(args: argparse.Namespace) -> dict[str, Keyword]:
    """Return the given loads as arguments of :func:`kinetostatics.analyze`."""
    found = given_of(("load", "point", "frame", "gravity"), args)
    loads: dict[str, list[LinkLoad]] = {}
    for link, *texts in args.load_on:
        loads.setdefault(link, []).append(_link_load(link, texts))
    if loads:
        found["loads"] = loads
    return found | payload_of(args)


def payload_of(args: argparse.Namespace) -> dict[str, Keyword]:
    """Return the given payload as an argument of :func:`kinetostatics.analyze`; empty without a payload."""
    mass, center = value_of("payload", args), value_of("payload_center", args)
    if mass is not None:
        from kinetostatics.description.loads import Payload

        return {"payload": Payload(mass, tuple(center or (0.0, 0.0, 0.0)), link=args.payload_link)}
    if center is not None or args.payload_link is not None:
        option = "--payload-link" if center is None else "--payload-center"
        raise ArgumentError(f"{option} gives the position of a payload, but its mass is missing: --payload 5kg")
    return {}


def _link_load(link: str, texts: list[str]) -> LinkLoad:
    """Return one load of ``--load-on``."""
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
