"""The pose that a command line asks for."""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

from kinetostatics.argument_checks import Keyword
from kinetostatics.cli.arguments import SEVERAL, number_of, parse_coordinates, parse_items, parse_values
from kinetostatics.description.units import PLATFORM_KINDS
from kinetostatics.exceptions import ArgumentError, AssemblyError, KinetostaticsError

if TYPE_CHECKING:
    from kinetostatics.kinematics.configuration import Configuration
    from kinetostatics.robot import Robot


def add_pose_arguments(
    parser: argparse.ArgumentParser,
    value: str = "VALUE",
    default: str = "Default: all actuators at zero, or the closed zero pose if that does not exist.",
    near: bool = True,
) -> None:
    """Add the pose: ``--platform`` or ``--actuators``, ``--near``, ``--orientation`` and ``--closure-tolerance``.

    Args:
        parser: of the command.
        value: what help calls the values.
        default: what help says of the pose.
        near: whether the way to the pose may begin at another one.
    """
    group = parser.add_argument_group("pose", default)
    either = group.add_mutually_exclusive_group()
    either.add_argument(
        "--platform",
        metavar=f"NAME={value}",
        **SEVERAL,
        help="coordinates of the platform, as many as its mobility: x y z of o, rx ry rz or azimuth tilt torsion",
    )
    either.add_argument(
        "--actuators",
        metavar=f"JOINT={value}",
        **SEVERAL,
        help="coordinates of all driven joints; those in no limb, as a gripper's, may be left out",
    )
    if near:
        group.add_argument(
            "--near",
            metavar="NAME=VALUE",
            **SEVERAL,
            help="another pose, of the platform or of the actuators, from which the straight way to this one begins; it tells "
            "the assembly mode (default: the closed zero pose)",
        )
    add_orientation_argument(group)
    group.add_argument(
        "--closure-tolerance", metavar="T", default="1e-10", help="how far loops may stay open, m and rad (default: %(default)s)"
    )


def add_orientation_argument(parser: argparse._ActionsContainer) -> None:
    """Add ``--orientation``."""
    parser.add_argument(
        "--orientation",
        metavar="NAME",
        help="what rx ry rz mean: rotation_vector (default), angles about moving axes (XYZ) or fixed axes (xyz), in any "
        "order of three letters; or tilt_torsion for azimuth tilt torsion",
    )


def assemble(robot: Robot, args: argparse.Namespace) -> tuple[Configuration, list[str]]:
    """Return the pose that the arguments ask for, and warnings."""
    option = "--actuators" if args.actuators else "--platform"
    given = single_values(robot, option, args.actuators or args.platform)
    try:
        return assembled(robot, option, given, args), []
    except AssemblyError:
        if given:
            raise
        # the file's zero may not be a pose of the robot; the pose nearest to it is
        q = robot.model_q(robot.zero_poses)[:, 0]
        pose = robot.configuration(q, closure_tolerance=closure_tolerance_of(args))
        return pose, ["the loops do not close with all actuators at zero; this is the closed pose nearest to the file's zero"]


def grid(robot: Robot | None, args: argparse.Namespace) -> tuple[str, dict[str, float | list[float]]]:
    """Return ``--platform`` or ``--actuators``, and its coordinates: values, and lists of them that make a grid.

    ``robot`` tells the kinds of actuators' coordinates.
    """
    option = "--actuators" if args.actuators else "--platform"
    items = parse_items(option, args.actuators or args.platform)
    return option, {name: parse_values(option, name, text, coordinate_kind(robot, option, name)) for name, text in items.items()}


def assembled(robot: Robot, option: str, coordinates: Mapping[str, object], args: argparse.Namespace) -> Configuration:
    """Return the poses at the coordinates of ``--platform`` or ``--actuators``; the zero pose where there are none."""
    options: dict[str, Keyword] = {"orientation": args.orientation, "closure_tolerance": closure_tolerance_of(args)}
    options["engine"] = getattr(args, "engine", "auto")
    start = near_pose(robot, args.near, options) if args.near else None
    options[option[2:]] = coordinates or None
    return robot.assemble(near=start, **options)


def near_pose(robot: Robot, near: list[str], options: Mapping[str, Keyword]) -> Configuration:
    """Return the pose that ``--near`` says; ``options`` are other arguments of :meth:`Robot.assemble`."""
    items = parse_items("--near", near)
    of = "platform" if all(name in PLATFORM_KINDS for name in items) else "actuators"
    begin = single_values(robot, f"--{of}", near, "--near")
    try:
        return robot.assemble(**{**options, of: begin})
    except KinetostaticsError as error:
        raise ArgumentError(f"--near: {error}") from error


def single_values(robot: Robot, option: str, items: Iterable[str], said: str | None = None) -> dict[str, float]:
    """Return one value of each coordinate of ``--platform`` or ``--actuators``; ``said`` is another option that gives them."""
    texts, said = parse_items(said or option, items), said or option
    return {name: parse_coordinates(said, name, [text], coordinate_kind(robot, option, name))[0] for name, text in texts.items()}


def coordinate_kind(robot: Robot | None, option: str, name: str) -> str | None:
    """Return whether a coordinate of ``--platform`` or ``--actuators`` is a "length" or an "angle", None if there is none."""
    if option == "--platform":
        return PLATFORM_KINDS.get(name)
    connection = None if robot is None else robot.mechanism.connections.get(name)
    return None if connection is None else connection.type.kind  # assemble() will list the names


def closure_tolerance_of(args: argparse.Namespace) -> float:
    """Return how far loops may stay open [m, rad]."""
    return number_of("--closure-tolerance", args.closure_tolerance, "length")
