"""Coefficients of a payload: sag and forces are linear in its mass and first moments."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from kinetostatics.layout.mapping import ResultMapping, ShortRepr
from kinetostatics.math.arrays import Array, Mask
from kinetostatics.math.linalg import cross
from kinetostatics.math.screws import wrench_of_couple, wrench_of_force
from kinetostatics.mechanism.tree import Frames
from kinetostatics.results.pose_arrays import Batch
from kinetostatics.statics.joint_wrenches import actuator_forces_from, joint_contributions, joints_in_order
from kinetostatics.statics.link_loads import PAYLOAD, AppliedLoad, link_frame
from kinetostatics.statics.robot_statics import RobotStatics
from kinetostatics.statics.solution import Solution
from kinetostatics.statics.springs import solve_with_springs

#: Names of the four parameters.
PARAMETERS = ("mass", "first_moment_x", "first_moment_y", "first_moment_z")


@dataclass(frozen=True, eq=False, repr=False)
class PayloadCoefficients(ShortRepr):
    """Twist and forces due to a payload of mass m [kg] with its centre at c [m], per unit of m, m c_x, m c_y and m c_z.

    ``coefficients.twist @ [m, *(m * c)]`` is its contribution to the twist; c is given in o-xyz, or in the frame of the link that
    carries the payload.

    Attributes:
        parameters: names of the four parameters: "mass" [kg], "first_moment_x", "first_moment_y", "first_moment_z" [kg·m].
        twist: (…, 6, 4) twist of the platform at o, world axes [m, rad] per unit.
        actuator_forces: (…, 4) force of each actuator [N or N·m] per unit.
        joint_wrenches: (…, 6, 4) wrench of each joint, at its centre, world axes [N, N·m] per unit.
    """

    parameters: tuple[str, ...]
    twist: Array
    actuator_forces: Mapping[str, Array]
    joint_wrenches: Mapping[str, Array]


def payload_coefficients(
    robot: RobotStatics, batch: Batch, solutions: Sequence[Solution], link: str | None
) -> PayloadCoefficients:
    """Return twist and forces due to a payload on ``link`` (None: the platform), per unit, at the poses of ``solutions``."""
    twists, forces, wrenches = [], [], []
    for solution in solutions:
        units = _unit_payloads(robot, solution.frames, solution.gravity, link, _places(robot, solution))
        groups = tuple(item.group for item in solution.statics)
        none = np.zeros_like(solution.load)
        found = solve_with_springs(robot, solution.frames, none, solution.gravity, None, groups, units)
        mine = slice(found.sources.index(units[0].name), found.sources.index(units[-1].name) + 1)
        twists.append(found.twists[:, mine])
        at_joints = joint_contributions(robot, found)[:, :, mine]
        wrenches.append(at_joints)
        forces.append(actuator_forces_from(robot, found, at_joints))
    return PayloadCoefficients(
        PARAMETERS,
        batch.public(twists),
        ResultMapping({name: batch.public([chunk[name] for chunk in forces]) for name in forces[0]}),
        ResultMapping({name: batch.public([chunk[:, k] for chunk in wrenches]) for name, k in joints_in_order(robot)}),
    )


def _places(robot: RobotStatics, solution: Solution) -> Mapping[str, Mask]:
    """Return the bodies that carry the payload, with the poses (N,) of each."""
    everywhere = np.ones(solution.o.shape[1], dtype=bool)
    for item in solution.applied:
        if item.load.name == PAYLOAD:
            several = len(item.load.wrenches) > 1
            return {name: np.any(w != 0, axis=0) if several else everywhere for name, w in item.load.wrenches.items()}
    return {robot.description.platform: everywhere}


def _unit_payloads(
    robot: RobotStatics, frames: Frames, gravity: Array, link: str | None, places: Mapping[str, Mask]
) -> tuple[AppliedLoad, ...]:
    """Return the weights of a unit mass at the origin of a payload's frame, and of unit first moments along its axes.

    The frame is that of ``link`` (None: o-xyz); ``places`` are the bodies that carry the payload, with the poses (N,) of each.
    """
    _, o = robot.mechanism.platform_pose(frames)
    R, origin = link_frame(robot, link, frames)
    wrenches = [wrench_of_force(gravity, origin - o), *(wrench_of_couple(cross(R[:, k], gravity)) for k in range(3))]
    return tuple(
        AppliedLoad(f"{PAYLOAD} {k}", {place: np.where(where, wrench, 0.0) for place, where in places.items()})
        for k, wrench in enumerate(wrenches)
    )
