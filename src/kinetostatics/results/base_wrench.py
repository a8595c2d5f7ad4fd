"""The base reaction of a chunk of poses: all that acts on the robot, reversed."""

from __future__ import annotations

from kinetostatics.math.arrays import Array
from kinetostatics.math.screws import move_wrench
from kinetostatics.results.limb import particular_limb_wrench
from kinetostatics.statics.applied_loads import sum_of
from kinetostatics.statics.model import RobotStatics
from kinetostatics.statics.solution import Solution


def base_wrench(robot: RobotStatics, solution: Solution) -> Array:
    """Return the ground's wrench (6, N) acting on the robot, about the base link's origin, world axes [N, N·m]."""
    weights, topology = solution.weights, robot.topology
    sum_at_o = weights[:, robot.weights.of("base")].sum(axis=1)
    sum_at_o += sum_of(solution.applied, topology.base.places)
    sum_at_o += sum_of(solution.applied, [place for limb in topology.limbs for place in limb.places])
    for number, statics in enumerate(solution.statics):
        if statics.group.is_attached:
            continue  # its weight is that of base or platform
        for position, limb in enumerate(statics.group.limbs):
            own = robot.weights.sum(limb.weights, weights)
            sum_at_o = sum_at_o + particular_limb_wrench(solution, number, position) + own
    body, placement = robot.mechanism.body_of[robot.description.base]
    origin = solution.frames.point(body, placement[:3, 3])
    return -move_wrench(sum_at_o, origin - solution.o)
