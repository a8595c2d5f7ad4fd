"""Ordinary poses of a robot within all limits: the zero pose, and poses at which one actuator is moved.

Ranks are decided at generic poses, which are near the zero pose and without symmetry. Choices made once per robot must be valid
at ordinary poses, too. Ordinary poses depend only on the actuators, not on frames, axes and cut loops of the file.
"""

from __future__ import annotations

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
