"""Robots from the notation of parallel mechanisms: ``new_robot`` and the text of its file."""

from __future__ import annotations

import inspect
import os
from collections.abc import Mapping, Sequence

from kinetostatics.analysis import analyze
from kinetostatics.arguments import Keyword, path_name
from kinetostatics.authoring.designing import Design, design_robot
from kinetostatics.authoring.file_text import file_text
from kinetostatics.authoring.known_names import options_of
from kinetostatics.authoring.notation import parse_architecture
from kinetostatics.authoring.placement import SYMMETRIC
from kinetostatics.exceptions import ArgumentError, StaticsError
from kinetostatics.files.reader import parse_robot_text
from kinetostatics.robot import Robot


def new_robot(
    architecture: str,
    path: str | os.PathLike[str] | None = None,
    *,
    base_radius: float | None = None,
    platform_radius: float | None = None,
    height: float | None = None,
    arrangement: str | None = None,
    azimuths: Sequence[float] | None = None,
    placements: object = None,
    guide: str | None = None,
    axis: str | None = None,
    sections: Mapping[str, str] | None = None,
    name: str | None = None,
    **values: Keyword,
) -> Robot:
    """Create a robot from a common name, such as ``"Delta"``, or from the notation of its limbs, ``"3-R[P]S"``.

    For the conventions see ``docs/start/robot_by_name.md``.

    Args:
        architecture: a common name, such as "Delta" (``kinetostatics new --list``), or limbs as strings of the joints R, P, U, S,
            C from base to platform, actuators in brackets or underlined, limbs joined by +: ``"2-[P]RU+U[P]R"``, ``"3-[R](4S)"``.
            Without marks, the usual actuators are chosen: in each limb the first prismatic joint, otherwise the joint at the
            base.
        path: path of the new xacro file; None: no file. An existing file is not replaced.
        base_radius: distance of the limbs' base points from Z [m]; default: that of the name, else 0.3.
        platform_radius: distance of their platform points from o [m]; default: that of the name, else 0.2.
        height: height of the platform's reference point o above the base frame's origin O, at the zero pose [m]; default: that of
            the name, else 0.5; negative for a suspended platform.
        arrangement: "symmetric" (evenly around Z), "planar" (the same, all revolute axes along Z, height 0 unless given),
            "cartesian" (three limbs along X, Y and Z) or "spherical" (limbs RRR whose axes all pass through O); default: that of
            the name, or of the only name that the limbs have, else symmetric.
        azimuths: azimuths of the limbs [rad]; default: evenly spaced.
        placements: instead of radii and azimuths: for each limb ``{"base": (x, y, z), "platform": (x, y, z)}`` in the frames of
            base and platform [m], optionally with "axis" (direction of its revolute axes) and "guide" (direction of its
            carriage's guide); or the path of a CSV file with these columns.
        guide: direction of the guides of limbs that begin with P: "vertical" (the default; "tangential" if planar), "radial" or
            "tangential".
        axis: direction of revolute axes: "radial", "tangential" or "vertical"; default: horizontal and perpendicular to the limb.
        sections: sections of beams by role, such as ``{"rod": "tube 60mm 50mm steel"}``; roles are rod, crank (of limbs with an
            elbow) and cylinder (a telescope in two pieces); "rod_4" is that of limb 4 and equal limbs.
        name: name of the robot; default: that of the file, or the architecture.
        values: other arguments of the file by name, SI units, such as ``rod_density=7820``, ``stroke=0.1`` or
            ``platform_mass=12``.

    Returns:
        The robot, loaded from the new text.

    Raises:
        ArgumentError: the notation or a value is invalid, or the platform is movable with locked actuators.
    """
    chosen = name if name is not None or path is None else os.path.basename(os.fsdecode(path)).split(".")[0]
    design = _design(
        architecture,
        dict(
            base_radius=base_radius,
            platform_radius=platform_radius,
            height=height,
            arrangement=arrangement,
            azimuths=azimuths,
            placements=placements,
            guide=guide,
            axis=axis,
            sections=sections,
            name=chosen,
        ),
        values,
    )
    text = file_text(design)
    robot = Robot(parse_robot_text(text, f"<{design.architecture.text}>" if path is None else path_name("path", path)))
    _check_held(robot, design.architecture.text)
    if path is not None:
        write_new(text, path)
    return robot


def robot_text(architecture: str, **options: Keyword) -> str:
    """Return the text of the file of :func:`new_robot`, with the same arguments except ``path``."""
    known = {item.name for item in inspect.signature(new_robot).parameters.values() if item.kind is item.KEYWORD_ONLY}
    values = {key: options.pop(key) for key in list(options) if key not in known}
    return file_text(_design(architecture, dict.fromkeys(known) | options, values))


def _design(architecture: str, options: dict[str, Keyword], values: Mapping[str, Keyword]) -> Design:
    """Return the design of a robot; missing arguments are those of its name, or defaults."""
    parsed = parse_architecture(architecture)
    given = {key: value for key, value in options.items() if value is not None}
    known = options_of(architecture, parsed.text, given)
    return design_robot(parsed, **{**options, "arrangement": SYMMETRIC, **known, **given}, values=values)


def _check_held(robot: Robot, architecture: str) -> None:
    """Check that the platform is constrained with locked actuators at the zero pose."""
    actuators, mobility = len(robot.description.driven), robot.mobility.platform
    if actuators < mobility:
        raise ArgumentError(f"{architecture} has {mobility} freedoms in this placement and only {actuators} actuators")
    try:
        analyze(robot.assemble())
    except StaticsError as error:
        raise ArgumentError(f"{architecture}, in this placement: {error}") from None


def write_new(text: str, path: str | os.PathLike[str]) -> None:
    """Write a new file.

    Raises:
        ArgumentError: the file exists, or cannot be written.
    """
    name = path_name("path", path)
    try:
        with open(name, "x", encoding="utf-8", newline="\n") as file:
            file.write(text)
    except FileExistsError:
        raise ArgumentError(f"{name} exists and is not overwritten; delete it or choose another name") from None
    except OSError as error:
        raise ArgumentError(f"{name} cannot be written: {error.strerror or error}") from None
