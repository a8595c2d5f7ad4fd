"""Numbers of a pose, and limits, that look as if they were in degrees or mm."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from kinetostatics.description.unit_hints import TURN, looks_like_degrees
from kinetostatics.files.parameter_units import parameter_unit
from kinetostatics.files.reader import parameter_values, read_robot_file

if TYPE_CHECKING:
    from kinetostatics.description.robot import RobotDescription
    from kinetostatics.kinematics.robot_kinematics import RobotKinematics
    from kinetostatics.mechanism.mechanism import Connection

#: So many times the robot's size a coordinate is too long.
FAR = 10.0
#: So many times a length of the robot's file are its values too long that may be tried instead.
LONG = 30.0
#: Such a part of a length, or of the robot's size, is a tolerance that looks like millimetres; so many rad look like mrad.
COARSE = 0.2


def odd_coordinates(robot: RobotKinematics, given: Mapping[str, ArrayLike]) -> list[str]:
    """Say which coordinates of actuators or platform [m, rad] are far longer than the robot, or look like degrees."""
    found = []
    for name, values in given.items():
        largest = _largest(values)
        joint = robot.mechanism.connections.get(name) if name in robot.description.driven else None
        slides = name in ("x", "y", "z") if joint is None else joint.type.is_slide
        if slides:
            size = robot.zero_size if largest else 0.0
            if abs(largest) > FAR * size > 0:
                found.append(
                    f"{name} = {largest:.6g} m is {abs(largest) / size:.3g} times the robot's size of {size:.3g} m: lengths are "
                    f"in m; write {largest / 1000:.6g} for {largest:.6g} mm, or {largest:.6g}mm on the command line"
                )
        elif _many_turns(joint, largest):
            found.append(
                f"{name} = {largest:.6g} rad is {largest / (2 * math.pi):.3g} turns: angles are in rad; write "
                f"{math.radians(largest):.6g} for {largest:.6g}°, or {largest:.6g}deg on the command line"
            )
    return found


def odd_point(what: str, point: ArrayLike, size: float) -> list[str]:
    """Say that a point of the platform (3,) [m], from o, is far longer away than the robot is large."""
    largest = _largest(point)
    if not abs(largest) > FAR * size > 0:
        return []
    return [
        f"{what} lies {abs(largest):.6g} m from o, {abs(largest) / size:.3g} times the robot's size of {size:.3g} m: "
        f"lengths are in m; write {largest / 1000:.6g} for {largest:.6g} mm, or {largest:.6g}mm on the command line"
    ]


def odd_parameters(path: str, parameters: Mapping[str, object], links: Mapping[str, str | None]) -> list[str]:
    """Say which parameters of a robot's file are lengths [m] far beyond the file's own; those below 1 are not looked at.

    Args:
        path, parameters, links: as :func:`kinetostatics.files.reader.read_robot_file` takes them.
    """
    given = {name: number for name, value in parameters.items() if (number := _number(value)) is not None and number >= 1}
    if not given:
        return []
    found, texts = [], parameter_values(path, {})
    for name, value in given.items():
        own = _number(texts.get(name))
        if own is None or not value > LONG * abs(own) > 0:
            continue
        if parameter_unit(own, partial(_with_value, path, name, links)) == "m":
            found.append(
                f"{name} = {value:.6g} m is {value / abs(own):.3g} times the file's own {own:.6g} m: lengths are in m; write "
                f"{value / 1000:.6g} for {value:.6g} mm, or {value:.6g}mm on the command line"
            )
    return found


def _with_value(path: str, name: str, links: Mapping[str, str | None], value: float) -> RobotDescription:
    return read_robot_file(path, {name: value}, **links)


def _number(value: object) -> float | None:
    try:
        return None if isinstance(value, bool) else float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        return None


def odd_range(name: str, low: float, high: float, own: float) -> list[str]:
    """Say that a length [m] is to be varied far from what it is in the robot's file."""
    if not low > LONG * abs(own) > 0:
        return []
    return [
        f"{name} from {low:.6g} m is {low / abs(own):.3g} times the file's own {own:.6g} m: lengths are in m; write "
        f"{low / 1000:.6g} to {high / 1000:.6g} for {low:.6g} to {high:.6g} mm, or {low:.6g}mm:{high:.6g}mm on the command line"
    ]


def odd_allowance(text: str, limit: float, size: float) -> list[str]:
    """Say that a requirement allows a displacement [m] as large as the robot."""
    if not limit > size > 0:
        return []
    return [
        f"{text} allows {limit:.6g} m, {limit / size:.3g} times the robot's size of {size:.3g} m: lengths are in m; write "
        f"{limit:.6g}mm or {limit:.6g}um"
    ]


def odd_angle(name: str, amount: float) -> list[str]:
    """Say that an angle [rad] may be off by more than any machine is."""
    if not amount > COARSE:
        return []
    return [
        f"{name} may be off by {amount:.6g} rad, which is {math.degrees(amount):.3g}°: angles are in rad; write "
        f"{amount / 1000:.6g} for {amount:.6g} mrad, or {amount:.6g}mrad on the command line"
    ]


def odd_tolerance(name: str, amount: float, own: float, size: float) -> list[str]:
    """Say that a length [m] may be off by much of what it is, or where it is zero by much of the robot's size."""
    whole, of = (abs(own), "the length itself") if own else (size, "the robot's size")
    if not amount > COARSE * whole > 0:
        return []
    return [
        f"{name} may be off by {amount:.6g} m, {amount / whole:.3g} times {of} of {whole:.3g} m: lengths are in m; write "
        f"{amount / 1000:.6g} for {amount:.6g} mm, or {amount:.6g}mm on the command line"
    ]


def _largest(values: ArrayLike) -> float:
    """Return the value farthest from zero of those that are finite; 0 if there is none."""
    if isinstance(values, int | float):
        return float(values) if math.isfinite(values) else 0.0
    numbers = np.nan_to_num(np.asarray(values, dtype=float), posinf=0.0, neginf=0.0).ravel()
    return float(numbers[np.argmax(np.abs(numbers))]) if numbers.size else 0.0


def _many_turns(joint: Connection | None, angle: float) -> bool:
    """Whether an angle is too large for the platform, or for an actuator that has no reason to turn so often."""
    if abs(angle) <= TURN:
        return False
    usual = joint is not None and (joint.type.endless or joint.lower <= angle <= joint.upper)
    return not usual or looks_like_degrees(angle)


def odd_limits(robot: RobotKinematics) -> list[str]:
    """Say which sliding joints have limits far beyond the robot's size, as those in mm are; wider ones stand for none at all."""
    size = robot.zero_size
    names: dict[float, list[str]] = {}
    for item in robot.mechanism.connections.values():
        largest = max((abs(limit) for limit in (item.lower, item.upper) if math.isfinite(limit)), default=0.0)
        if item.type.is_slide and FAR * size < largest <= 1000 * FAR * size:
            names.setdefault(largest, []).append(item.name)
    return [
        f"the limits of {', '.join(joints)} go to {largest:.6g} m, {largest / size:.3g} times the robot's size of {size:.3g} m: "
        "lengths are in m"
        for largest, joints in names.items()
    ]


def odd_springs(robot: RobotKinematics) -> list[str]:
    """Say which springs have a free length far beyond the robot's size, as those in mm are."""
    size = robot.size
    return [
        f"the free length of spring {name!r} is {item.free_length:.6g} m, {item.free_length / size:.3g} times the robot's size "
        f"of {size:.3g} m: lengths are in m; write {item.free_length / 1000:.6g} for {item.free_length:.6g} mm"
        for name, item in robot.description.springs.items()
        if item.free_length > FAR * size > 0
    ]
