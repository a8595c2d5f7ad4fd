"""Poses of other modes, from which poses are tried that the zero pose's does not reach."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from kinetostatics.exceptions import KinetostaticsError
from kinetostatics.math.arrays import Array
from kinetostatics.robot import Robot
from kinetostatics.status import Status


def open_starts(robot: Robot, units: Sequence[str], count: int, seed: int = 1) -> Array:
    """Return random model coordinates (n, nq), loops open, always the same ones.

    Args:
        robot: the robot.
        units: of its model coordinates.
        count: how many.
        seed: which ones.
    """
    random = np.random.default_rng(seed)
    zero = robot.model_q(robot.zero_poses)[:, 0]
    reach = np.where([unit == "m" for unit in units], robot.length, np.pi)
    q = zero + random.uniform(-1, 1, (count, len(zero))) * reach
    for first, size in zip(list(robot.mechanism.model.idx_qs), list(robot.mechanism.model.nqs), strict=True):
        if size == 2:
            angle = random.uniform(-np.pi, np.pi, count)
            q[:, first], q[:, first + 1] = np.cos(angle), np.sin(angle)
        elif size > 2:
            q[:, first : first + size] = zero[first : first + size]
    return np.asarray(q)


def closed_starts(robot: Robot, count: int, closure_tolerance: float) -> Array:
    """Return model coordinates (n, nq) of poses at random actuator coordinates, those that exist: n may be 0.

    Moving the actuators leads through poses at which a limb is stretched or folded, and so to poses that straight lines of the
    platform do not reach.

    Args:
        robot: the robot.
        count: how many are tried.
        closure_tolerance: how far loops may stay open [m, rad].
    """
    random = np.random.default_rng(2)
    zero = robot.configuration(robot.model_q(robot.zero_poses)[:, 0], closure_tolerance=np.inf).actuators
    connections = robot.mechanism.connections
    values = {}
    for name, value in zero.items():
        reach = robot.length if connections[name].type.is_slide else np.pi
        values[name] = float(value) + random.uniform(-reach, reach, count)
    none = np.zeros((0, robot.mechanism.tree.nq))
    if not values:
        return none
    try:
        found = robot.assemble(actuators=values, closure_tolerance=closure_tolerance, on_failure="nan")
    except KinetostaticsError:  # the actuators do not determine the pose
        return none
    return found.q[found.status != Status.UNREACHABLE]
