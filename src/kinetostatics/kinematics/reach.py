"""Reach of a robot: ends of straight lines of coordinates, and ordinary poses within all limits.

A line ends at a joint limit, at a singular pose, or where the loops cannot be closed. Ordinary poses are the zero pose and poses
at which one actuator is moved. Ranks are decided at generic poses, which are near the zero pose and without symmetry. Choices
made once per robot must be valid at ordinary poses, too. Ordinary poses depend only on the actuators, not on frames, axes and cut
loops of the file.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from kinetostatics.kinematics.assembly import SolverChoice, assemble, by_numpy, configuration_at
from kinetostatics.kinematics.configuration import Configuration, taken
from kinetostatics.kinematics.robot_kinematics import RobotKinematics
from kinetostatics.math.arrays import Array
from kinetostatics.status import Status

#: Number of intervals into which a line is divided in the first search, and the interval with its end in each further search.
FIRST, NEXT = 32, 24
#: Accuracy of the end, as a fraction of the line.
FINE = 6e-5
#: Largest travel of actuators from zero [rad], or relative to the characteristic length.
_FAR = 1.2
#: Positions of the actuators relative to their limits; with more actuators than ``_MANY``, only the first.
_PARTS, _MANY = (0.2, 0.6), 8


@dataclass(frozen=True)
class End:
    """The end of a line of coordinates.

    Attributes:
        part: admissible fraction of the line, 0 to 1.
        reason: reason for the end: "limit", a joint limit; "singular", a singular pose with locked actuators; "loops", loops that
            cannot be closed; "", the whole line is admissible.
        joint: name of the joint with the limit or cone, for the reason "limit".
        limit: this limit [m, rad].
    """

    part: float
    reason: str = ""
    joint: str = ""
    limit: float = math.nan


def find_ends(
    pose: Configuration,
    kind: str,
    ways: Mapping[str, Array],
    orientation: str | None = None,
    chosen: SolverChoice = by_numpy,
    proceed: Callable[[], bool] = lambda: True,
) -> list[End]:
    """Return the ends of L straight lines of coordinates that start at one pose.

    All lines are divided into intervals at once; the interval with the end is divided again until it is short. Joint limits
    exceeded at the start are ignored; singular poses are ignored if the start is singular.

    Args:
        pose: the start, a single pose.
        kind: kind of the coordinates: "platform" or "actuators".
        ways: changes (L,) of each coordinate along the lines [m, rad], by the coordinate's name; the coordinates must determine
            the pose.
        orientation, chosen: as in :func:`.assembly.assemble`.
        proceed: called before each division; if it returns False, the result is an empty list.
    """
    present = pose.platform_coordinates(orientation) if kind == "platform" else pose.actuators
    count = next((len(way) for way in ways.values()), 0)
    low, high, ends = np.zeros(count), np.ones(count), [End(1.0)] * count
    near, parts = pose, FIRST
    while count and np.max(high - low) > FINE:
        if not proceed():
            return []
        along = low[:, None] + (high - low)[:, None] * np.linspace(0, 1, parts + 1)
        given = {name: float(present[name]) + along * way[:, None] for name, way in ways.items()}
        actuators, platform = (None, given) if kind == "platform" else (given, None)
        poses = assemble(pose.robot, actuators, platform, orientation, near, pose.closure_tolerance, "nan", chosen)
        last = np.full(count, parts)
        for n, line in enumerate(_reasons(poses, pose)):
            first = next((k for k, end in enumerate(line) if k and end is not None), None)
            if first is not None:
                last[n], ends[n] = first - 1, line[first] or ends[n]
            low[n], high[n] = along[n, last[n]], along[n, last[n] if first is None else first]
        near = taken(poses, np.repeat(np.arange(count) * (parts + 1) + last, NEXT + 1), (count, NEXT + 1))
        parts = NEXT
    return [replace(end, part=float(part)) for end, part in zip(ends, low, strict=True)]


def _reasons(poses: Configuration, pose: Configuration) -> list[list[End | None]]:
    """Return, for each pose (L, n) on the lines, the reason why it is inadmissible; None if it is admissible."""
    robot, (count, n) = pose.robot, poses.shape
    reasons: list[End | None] = [None] * (count * n)
    prescribed = robot.actuator_coordinates
    if robot.mobility_analysis.fixes_platform_at(prescribed, pose.poses):
        before = np.maximum(np.arange(count * n) - (np.arange(count * n) % n > 0), 0)
        alike = robot.solver.on_one_side(prescribed, poses.poses.take(before), poses.poses, np.zeros((prescribed.size, 1)))
        for k in np.flatnonzero(~alike):
            reasons[k] = End(0.0, "singular")
    for joint, exceeded in poses.limits_exceeded.items():
        if joint not in pose.limits_exceeded:
            for k in np.flatnonzero(exceeded.where):
                value = float(exceeded.value.flat[k])
                reasons[k] = End(0.0, "limit", joint, exceeded.lower if value < exceeded.lower else exceeded.upper)
    for k in np.flatnonzero(~poses.reached):
        reasons[k] = End(0.0, "loops")
    return [reasons[n * k : n * (k + 1)] for k in range(count)]


def ordinary_poses(robot: RobotKinematics) -> Array:
    """Return Pinocchio's coordinates (nq, N) of the closed zero pose and of a few dozen poses within the limits."""
    zero = robot.model_q(robot.zero_poses)
    names = robot.actuator_names
    if not names:
        return zero
    prescribed = robot.mobility_analysis.with_dofs(robot.actuator_coordinates)
    start = robot.zero_origin(prescribed)[0]
    travel = np.concatenate([np.diag([_travel(robot, name)[side] for name in names]) for side in (0, 1)], axis=1)
    poses = robot.zero_poses.take(np.zeros(travel.shape[1], dtype=np.intp))
    coordinates = [zero]
    for part in _PARTS if len(names) <= _MANY else _PARTS[:1]:
        poses, good = robot.solver.newton(prescribed, poses, start + part * travel)
        poses, travel = poses.take(good), travel[:, good]
        coordinates.append(robot.model_q(poses))
    reached = configuration_at(robot, np.hstack(coordinates[1:]).T, np.inf, "nan")
    return np.hstack([zero, reached.model_q[:, reached.status == Status.OK]])


def _travel(robot: RobotKinematics, name: str) -> tuple[float, float]:
    """Return (a, b) [m, rad]: how far an actuator is moved below and above zero; a ≤ 0, b ≥ 0."""
    joint = robot.mechanism.connections[name]
    far = _FAR * (robot.length if joint.type.is_slide else 1.0)
    return min(max(joint.lower, -far), 0.0), max(min(joint.upper, far), 0.0)
