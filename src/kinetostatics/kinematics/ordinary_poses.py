"""Ordinary poses: the zero pose, and those reached by moving each actuator alone, within all limits.

Ranks are decided at generic poses, near the zero pose and without symmetry. Ordinary poses are those commonly analysed;
choices made once per robot must be valid there. They depend on the actuators only, not on frames, axes and cut loops of the file.
"""

from __future__ import annotations

import math

import numpy as np

from kinetostatics.kinematics.assembly import configuration_at
from kinetostatics.kinematics.robot_kinematics import RobotKinematics
from kinetostatics.math.arrays import Array
from kinetostatics.status import Status

#: Largest travel of actuators from zero [rad], or relative to the characteristic length.
_FAR = 1.2
#: Positions of the actuators relative to their limits; with more actuators than ``_MANY``, only the first.
_PARTS, _MANY = (0.2, 0.6), 8


def ordinary_poses(robot: RobotKinematics) -> Array:
    """Return Pinocchio's coordinates (nq, N) of the closed zero pose and of a few dozen poses within the limits."""
    zero = robot.model_q(robot.zero_poses)
    names = robot.actuator_names
    if not names:
        return zero
    prescribed = robot.mobility_analysis.with_dofs(robot.actuator_coordinates)
    start = robot.zero_origin(prescribed)[0]
    travel = np.concatenate([np.diag([_reach(robot, name)[side] for name in names]) for side in (0, 1)], axis=1)
    poses = robot.zero_poses.take(np.zeros(travel.shape[1], dtype=np.intp))
    found = [zero]
    for part in _PARTS if len(names) <= _MANY else _PARTS[:1]:
        poses, good = robot.solver.newton(prescribed, poses, start + part * travel)
        poses, travel = poses.take(good), travel[:, good]
        found.append(robot.model_q(poses))
    reached = configuration_at(robot, np.hstack(found[1:]).T, np.inf, "nan")
    return np.hstack([zero, reached.model_q[:, reached.status == Status.OK]])


def _reach(robot: RobotKinematics, name: str) -> tuple[float, float]:
    """Return the travel of an actuator below and above zero [m, rad]."""
    item = robot.mechanism.connections[name]
    far = _FAR * (robot.length if item.type.is_slide else 1.0)
    low = item.lower if math.isfinite(item.lower) else -far
    high = item.upper if math.isfinite(item.upper) else far
    return min(max(low, -far), 0.0), max(min(high, far), 0.0)
