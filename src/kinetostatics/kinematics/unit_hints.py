"""Numbers that look as if they were in degrees or mm: coordinates, limits and angles of a file."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from kinetostatics.description.joint_types import names_of
from kinetostatics.exceptions import KinetostaticsError
from kinetostatics.printing.text import listing

if TYPE_CHECKING:
    from kinetostatics.description.elements import Joint, Loop
    from kinetostatics.description.robot import RobotDescription
    from kinetostatics.kinematics.robot_kinematics import RobotKinematics
    from kinetostatics.mechanism.mechanism import Connection

TURN = 2 * math.pi * (1 + 1e-9)
#: Plausible numbers of solids: Young's modulus [Pa] and density [kg/m³].
MODULI, DENSITIES = (1e8, 2e12), (10.0, 25e3)
#: Wider limits [rad] than this stand for none at all.
WIDE = 720.0
#: So many times the robot's size a coordinate is too long.
FAR = 10.0


def robot_size(robot: RobotKinematics) -> float:
    """Return the diagonal of the box around all joints and links at the zero pose [m]; NaN if there is no such pose."""
    try:
        points = robot.zero_frames.position[:, :, 0]
    except KinetostaticsError:
        return math.nan
    points = points[:, np.all(np.isfinite(points), axis=0)]
    return float(np.linalg.norm(points.max(axis=1) - points.min(axis=1)))


def looks_like_degrees(*angles: float) -> bool:
    """Whether angles make more than two turns in radians, or more than one and are round numbers of degrees: 90, 10, -180.

    Sums of angles, as xacro makes them, go a little beyond a turn.
    """
    largest = max(map(abs, angles))
    return largest > 2 * TURN or (largest > TURN and all(angle % 5 == 0 for angle in angles))


def odd_coordinates(robot: RobotKinematics, given: Mapping[str, ArrayLike]) -> list[str]:
    """Say which coordinates of drives or platform [m, rad] are far longer than the robot, or look like degrees."""
    found, size = [], robot_size(robot)
    for name, values in given.items():
        numbers = np.nan_to_num(np.asarray(values, dtype=float), posinf=0.0, neginf=0.0).ravel()
        largest = float(numbers[np.argmax(np.abs(numbers))]) if numbers.size else 0.0
        joint = robot.mechanism.connections.get(name) if name in robot.description.driven else None
        slides = name in ("x", "y", "z") if joint is None else joint.type.is_slide
        if slides:
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


def _many_turns(joint: Connection | None, angle: float) -> bool:
    """Whether an angle is too large for the platform, or for a drive that has no reason to turn so often."""
    if abs(angle) <= TURN:
        return False
    usual = joint is not None and (joint.type.endless or joint.lower <= angle <= joint.upper)
    return not usual or looks_like_degrees(angle)


def odd_angles(description: RobotDescription) -> list[str]:
    """Say which angles and limits of a robot file look like degrees."""
    found = [
        f"{item.place}: rpy={_written(rpy)!r} of {what} looks like degrees: angles are in rad; 90 degrees are ${{pi/2}} in xacro"
        for what, item, rpy in _origins(description)
        if looks_like_degrees(*rpy)
    ]
    followed = {joint.mimic.joint for joint in description.joints.values() if joint.mimic is not None}
    joints: list[Joint | Loop] = [*description.joints.values(), *description.loops.values()]
    turning = [joint for joint in joints if joint.type in names_of("is_hinge") and joint.name not in followed]
    for joint in turning:
        limits = [limit for limit in (joint.lower, joint.upper) if math.isfinite(limit)]
        if limits and 2 * TURN < max(map(abs, limits)) <= WIDE:
            found.append(
                f"{joint.place}: the limits {_written((joint.lower, joint.upper))} of {joint.name!r} look like degrees: angles "
                "are in rad; 90 degrees are ${pi/2} in xacro"
            )
    return found


def _origins(description: RobotDescription) -> Iterable[tuple[str, Joint | Loop, tuple[float, float, float]]]:
    for joint in description.joints.values():
        yield f"the joint {joint.name!r}", joint, joint.origin.rpy
    for loop in description.loops.values():
        yield f"the loop {loop.name!r}", loop, loop.predecessor_origin.rpy
        yield f"the loop {loop.name!r}", loop, loop.successor_origin.rpy


def _written(numbers: Iterable[float]) -> str:
    return " ".join(f"{number:.6g}" for number in numbers)


def odd_limits(robot: RobotKinematics) -> list[str]:
    """Say which sliding joints have limits far beyond the robot's size, as those in mm are; wider ones stand for none at all."""
    size = robot_size(robot)
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


def odd_materials(description: RobotDescription) -> list[str]:
    """Say which moduli and densities of beams are not those of solids, and in which unit they would be."""
    found: dict[str, list[str]] = {}
    for name, beam in description.beams.items():
        modulus, density = beam.material.youngs_modulus, beam.material.density
        if not MODULI[0] <= modulus <= MODULI[1]:
            meant = _meant(modulus, MODULI, {"GPa": 1e9, "MPa": 1e6})
            found.setdefault(f"a Young's modulus of {modulus:.4g} Pa; moduli are in Pa (steel: 2.1e11){meant}", []).append(name)
        if density and not DENSITIES[0] <= density <= DENSITIES[1]:
            meant = _meant(density, DENSITIES, {"g/cm³": 1e3, "kg/mm³": 1e9, "t/mm³": 1e12})
            found.setdefault(f"a density of {density:.4g} kg/m³; densities are in kg/m³ (steel: 7850){meant}", []).append(name)
    return [
        f"beam{'s' * (len(names) > 1)} {listing(names, 8)} {'have' if names[1:] else 'has'} {words}"
        for words, names in found.items()
    ]


def _meant(value: float, usual: tuple[float, float], units: Mapping[str, float]) -> str:
    """Say in which unit a value would be a usual one."""
    for unit, size in units.items():
        if usual[0] <= value * size <= usual[1]:
            return f": {value:.4g} {unit} is {value * size:.4g}"
    return ""
