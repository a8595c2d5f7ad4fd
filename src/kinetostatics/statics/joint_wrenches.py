"""Wrenches of joints, limbs and base, and forces of actuators, at N poses, from cut-joint wrenches and weights.

A joint's wrench acts from its base side on its platform side, at the joint's centre, in world axes. The joint table,
:class:`kinetostatics.statics.robot_statics.JointTable`, has J joints. A self-stress of rigid parts makes wrenches statically
indeterminate.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from kinetostatics.math.arrays import Array, zeros_for
from kinetostatics.math.screws import move_wrench
from kinetostatics.statics.link_loads import by_attachment, sum_of
from kinetostatics.statics.robot_statics import RobotStatics
from kinetostatics.statics.solution import Solution

#: Largest component of a normalized self-stress (rounding) with which a joint's wrench counts as determined.
_NOTHING = 1e-9


def joints_in_order(robot: RobotStatics) -> list[tuple[str, int]]:
    """Return the joints in the order of the file, each with its row in the joint table."""
    places = {name: k for k, name in enumerate(robot.joint_table.names)}
    return [(name, places[name]) for name in robot.mechanism.connections if name in places]


def joint_wrenches(robot: RobotStatics, solution: Solution) -> Array:
    """Return the wrenches (6, J, N) of all joints [N, N·m]; NaN where they are statically indeterminate."""
    return _masked(carried_wrenches(robot, solution), _self_stresses(robot, solution))


def actuator_forces(robot: RobotStatics, solution: Solution) -> dict[str, Array]:
    """Return the force or torque (N,) of each actuator, positive along its coordinate; NaN if statically indeterminate."""
    table = robot.joint_table
    followers = [joint.name for joint in robot.mechanism.connections.values() if joint.mimic is not None]
    names = [name for name in (*robot.description.actuated, *followers) if name in table.names]
    which = [table.names.index(name) for name in names]
    forces = actuator_forces_from(robot, solution, carried_wrenches(robot, solution, which), names)
    undetermined = _self_stresses(robot, solution, which)
    if undetermined is None:
        return forces
    changes = actuator_forces_from(robot, solution, undetermined, names)
    return {name: np.where(np.max(np.abs(changes[name]), axis=0) > _NOTHING, np.nan, force) for name, force in forces.items()}


def carried_wrenches(robot: RobotStatics, solution: Solution, joints: Sequence[int] | None = None) -> Array:
    """Return the wrenches (6, J, N) of joints in given rows of the joint table (None: all).

    Where they are statically indeterminate, one solution is returned. A joint of a serial limb has the wrench −(J_ic W_ic + J_ig
    W_ig + Σ w), with the weights w outboard of this joint (method page, section 7).
    """
    table = robot.joint_table
    which = slice(None) if joints is None else list(joints)
    cut_signs = zeros_for((6, table.cut_signs.shape[1], solution.o.shape[1]), solution.o)
    for number, statics in enumerate(solution.statics):
        total = solution.total_cut_wrenches(number)
        for position, limb in enumerate(statics.group.numbers):
            cut_signs[:, table.cuts_of(limb)] = total[:, :, position].swapaxes(0, 1)
    carried = np.einsum("jq,iqn->ijn", table.cut_signs[which], cut_signs)
    carried += np.einsum("jw,iwn->ijn", table.outboard[which], solution.weights)
    for attachment, wrench in by_attachment(solution.applied).items():
        carried += table.carrying(attachment)[which][:, None] * wrench[:, None]
    return table.reported[which][:, None] * move_wrench(carried, _arms(robot, solution, which))


def joint_contributions(robot: RobotStatics, solution: Solution) -> Array:
    """Return the contributions (6, J, S, N) to the wrenches of all joints; NaN where these are statically indeterminate.

    Weights of bodies attached only to the base are no contribution.
    """
    table, S = robot.joint_table, len(solution.contributions)
    cut_signs = zeros_for((6, table.cut_signs.shape[1], S + 1, solution.o.shape[1]), solution.o)
    for number, statics in enumerate(solution.statics):
        parts = solution.cut_wrenches(number)
        for position, limb in enumerate(statics.group.numbers):
            cut_signs[:, table.cuts_of(limb), : parts.shape[2]] = parts[:, :, :, position].swapaxes(0, 1)
    carried = np.einsum("jq,iqsn->ijsn", table.cut_signs, cut_signs)
    place = {"base": S, "platform": 1} | {name: k for k, name in enumerate(solution.contributions)}
    own = np.array([place[owner] for owner in table.owners], dtype=np.intp)
    carried[:, np.arange(len(own)), own] += np.einsum("jw,iwn->ijn", table.outboard, solution.weights)
    for item in solution.applied:
        for where, wrench in item.load.wrenches.items():
            carried[:, :, :S] += table.carrying(where)[:, None, None] * (wrench[:, None] * item.share)[:, None]
    wrenches = table.reported[:, None, None] * move_wrench(carried[:, :, :S], _arms(robot, solution)[:, :, None])
    return _masked(wrenches, _self_stresses(robot, solution))


def actuator_forces_from(
    robot: RobotStatics, solution: Solution, wrenches: Array, names: Sequence[str] | None = None
) -> dict[str, Array]:
    """Return the force or torque f (…, N) of each actuator, positive along its coordinate, from joint wrenches (6, J, …, N).

    f = Sᵀ w, the power of the joint's wrench w on the actuator's unit twist S, Eq. (17). Joints that mimic the actuator's joint
    add their powers, times their multipliers. ``names`` are the joints of the wrenches (None: all of the joint table).
    """
    table = robot.joint_table
    places = {name: k for k, name in enumerate(table.names if names is None else names)}

    def along(joint: str) -> Array:
        if joint not in places:
            return np.zeros(wrenches.shape[2:])
        connection = robot.mechanism.connections[joint]
        axis = solution.frames.direction(connection.predecessor_body, connection.axis_on(True))
        mine = wrenches[:, places[joint]]
        part = mine[:3] if connection.type.is_slide else mine[3:]
        return np.asanyarray(table.signs[joint] * np.einsum("in,i...n->...n", axis, part))

    forces = {name: along(name) for name in robot.description.actuated}
    for joint in robot.mechanism.connections.values():
        if joint.mimic is not None:
            forces[joint.mimic.joint] = forces[joint.mimic.joint] + joint.mimic.multiplier * along(joint.name)
    return forces


def _arms(robot: RobotStatics, solution: Solution, which: slice | list[int] = slice(None)) -> Array:
    table = robot.joint_table
    return solution.frames.points(table.centre_body[which], table.centre[:, which]) - solution.o[:, None]


def _masked(wrenches: Array, undetermined: Array | None) -> Array:
    """Return joint wrenches (6, J, …, N) with NaN where self-stresses ``undetermined`` (6, J, K, N) have a wrench."""
    if undetermined is None:
        return wrenches
    unknown = np.max(np.abs(undetermined), axis=(0, 2)) > _NOTHING
    return np.where(unknown.reshape(unknown.shape[0], *(1,) * (wrenches.ndim - 3), unknown.shape[1]), np.nan, wrenches)


def _self_stresses(robot: RobotStatics, solution: Solution, joints: Sequence[int] | None = None) -> Array | None:
    """Return the joint wrenches (6, J, K, N) of K self-stresses of rigid parts; None without self-stress.

    Each self-stress is scaled: its largest force, or moment divided by the characteristic length, is 1.
    """
    table, N = robot.joint_table, solution.o.shape[1]
    # self-stress between rigid limbs changes the forces of several limbs together
    shared = np.zeros((6, table.cut_signs.shape[1], max((item.shape[1] for item in solution.self_stresses), default=0), N))
    states = [shared]
    for number, statics in enumerate(solution.statics):
        together = np.einsum("mkign,iagn->mkagn", statics.cut_wrenches, solution.self_stresses[number])
        undetermined = np.zeros((6, table.cut_signs.shape[1], statics.undetermined.shape[2], N))
        for position, limb in enumerate(statics.group.numbers):
            which = table.cuts_of(limb)
            shared[:, which, : together.shape[2]] = together[:, :, :, position].swapaxes(0, 1)
            undetermined[:, which] = statics.undetermined[:, :, :, position].swapaxes(0, 1)
        states.append(undetermined)
    states = [state for state in states if np.any(state)]
    if not states:
        return None
    carried = np.einsum("jq,iqan->ijan", table.cut_signs, np.concatenate(states, axis=2))
    moved = move_wrench(carried, _arms(robot, solution)[:, :, None])
    sizes = np.maximum(np.abs(moved[:3]), np.abs(moved[3:]) / robot.length).max(axis=(0, 1))
    moved = moved / np.where(sizes > 0, sizes, 1.0)
    return moved if joints is None else moved[:, list(joints)]


def limb_wrench(solution: Solution, number: int, position: int) -> Array:
    """Return the platform's wrench J_ic W_ic + J_ig W_ig (6, N) on a limb about o; if indeterminate, one of the solutions."""
    statics = solution.statics[number]
    intensities = solution.intensities[number][:, :, position].sum(axis=1)
    return np.einsum("kin,in->kn", statics.J_c[:, :, position], intensities) + statics.R_g[:, position]


def base_wrench(robot: RobotStatics, solution: Solution) -> Array:
    """Return the ground's wrench (6, N) on the robot, about the base link's origin, world axes [N, N·m].

    This wrench is −Σ (loads + weights) of base and limbs − Σ (J_ic W_ic + J_ig W_ig).
    """
    weights, topology = solution.weights, robot.topology
    sum_at_o = weights[:, robot.weights.of("base")].sum(axis=1)
    sum_at_o += sum_of(solution.applied, topology.base.attachments)
    sum_at_o += sum_of(solution.applied, [attachment for limb in topology.limbs for attachment in limb.attachments])
    for number, statics in enumerate(solution.statics):
        if not statics.group.is_attached:  # its weight counts as that of base or platform
            for position, limb in enumerate(statics.group.limbs):
                own = robot.weights.sum(limb.weights, weights)
                sum_at_o = sum_at_o + limb_wrench(solution, number, position) + own
    body, placement = robot.mechanism.body_of[robot.description.base]
    origin = solution.frames.point(body, placement[:3, 3])
    return -move_wrench(sum_at_o, origin - solution.o)
