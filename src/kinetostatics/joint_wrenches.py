"""Wrenches of all joints and forces of all drives, from the limbs' chord wrenches and the weights; one chunk of poses at a time.

Wrenches are what a joint's base side puts on its platform side, at the joint's centre, world axes.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from kinetostatics.equilibrium import Solution
from kinetostatics.robot import Robot
from kinetostatics.screws import move_wrench

Array = NDArray[np.float64]


def joint_wrenches(robot: Robot, solution: Solution, joints: Sequence[int] | None = None) -> Array:
    """Return the wrenches (6, J, N) of the joints of the robot's joint table, NaN where rigid parts leave them open.

    Args:
        robot: the robot.
        solution: the chunk of poses.
        joints: places of some joints in the table; None: all.
    """
    table = robot.joint_table
    which = slice(None) if joints is None else list(joints)
    chords = np.zeros((6, table.chords.shape[1], solution.o.shape[1]))
    for number, statics in enumerate(solution.statics):
        total = solution.total_chord_wrenches(number)
        for position, limb in enumerate(statics.group.numbers):
            chords[:, table.chords_of(limb)] = total[:, :, position].swapaxes(0, 1)
    carried = np.einsum("jq,iqn->ijn", table.chords[which], chords)
    carried += np.einsum("jw,iwn->ijn", table.outboard[which], solution.weights)
    arms = solution.frames.points(table.centre_body[which], table.centre[:, which]) - solution.o[:, None]
    wrenches = table.reported[which][:, None] * move_wrench(carried, arms)
    unknown = _undetermined(robot, solution)
    return np.where(unknown[which], np.nan, wrenches) if np.any(unknown) else wrenches


def actuator_forces(robot: Robot, solution: Solution) -> dict[str, Array]:
    """Return the force or torque (N,) of each drive, positive along its coordinate."""
    table = robot.joint_table
    followers = [joint.name for joint in robot.mechanism.connections.values() if joint.mimic is not None]
    names = [name for name in (*robot.description.driven, *followers) if name in table.names]
    wrenches = joint_wrenches(robot, solution, [table.names.index(name) for name in names])
    return drive_forces(robot, solution, wrenches, names)


def joint_contributions(robot: Robot, solution: Solution) -> Array:
    """Return the wrenches (6, J, S, N) by contribution; the weights of what hangs on the base belong to none."""
    table, S = robot.joint_table, len(solution.sources)
    chords = np.zeros((6, table.chords.shape[1], S + 1, solution.o.shape[1]))
    for number, statics in enumerate(solution.statics):
        parts = solution.chord_wrenches(number)
        for position, limb in enumerate(statics.group.numbers):
            chords[:, table.chords_of(limb), : parts.shape[2]] = parts[:, :, :, position].swapaxes(0, 1)
    carried = np.einsum("jq,iqsn->ijsn", table.chords, chords)
    place = {"base": S, "platform": 1} | {name: k for k, name in enumerate(solution.sources)}
    own = np.array([place[owner] for owner in table.owners], dtype=np.intp)
    carried[:, np.arange(len(own)), own] += np.einsum("jw,iwn->ijn", table.outboard, solution.weights)
    wrenches = table.reported[:, None, None] * move_wrench(carried[:, :, :S], _arms(robot, solution)[:, :, None])
    return np.where(_undetermined(robot, solution)[:, None], np.nan, wrenches)


def drive_forces(robot: Robot, solution: Solution, wrenches: Array, names: Sequence[str] | None = None) -> dict[str, Array]:
    """Return the force or torque (…, N) of each drive, positive along its coordinate, from joint wrenches (6, J, …, N).

    A drive that other joints mimic moves them too: their forces count with their multipliers. ``names`` are those of the joints
    that the wrenches belong to; None: all of the robot's joint table.
    """
    table = robot.joint_table
    places = {name: k for k, name in enumerate(table.names if names is None else names)}

    def along(joint: str) -> Array:
        if joint not in places:
            return np.zeros(wrenches.shape[2:])
        connection = robot.mechanism.connections[joint]
        axis = solution.frames.directions(np.array([connection.predecessor_body]), connection.axis_on(True)[:, None])[:, 0]
        mine = wrenches[:, places[joint]]
        part = mine[:3] if connection.kind == "prismatic" else mine[3:]
        return np.asarray(table.signs[joint] * np.einsum("in,i...n->...n", axis, part))

    forces = {name: along(name) for name in robot.description.driven}
    for joint in robot.mechanism.connections.values():
        if joint.mimic is not None:
            forces[joint.mimic.joint] = forces[joint.mimic.joint] + joint.mimic.multiplier * along(joint.name)
    return forces


def _arms(robot: Robot, solution: Solution) -> Array:
    table = robot.joint_table
    return solution.frames.points(table.centre_body, table.centre) - solution.o[:, None]


def _undetermined(robot: Robot, solution: Solution) -> NDArray[np.bool_]:
    """Return which joints' wrenches (J, N) rigid parts leave open: all of a limb of whose intensities one is, and rigid rings."""
    table = robot.joint_table
    unknown = np.zeros((len(table.names), solution.o.shape[1]), dtype=bool)
    for number, statics in enumerate(solution.statics):
        any_open = np.any(solution.undetermined[number], axis=0)
        loose = statics.loose.shape[2] > 0
        if not (loose or np.any(any_open)):
            continue
        for position, limb in enumerate(statics.group.numbers):
            mine = table.chords[:, table.chords_of(limb)]
            unknown |= np.any(mine, axis=1)[:, None] & any_open[position]
            if loose:
                carried = np.abs(np.einsum("jm,misn->jisn", mine, statics.loose[:, :, :, position]))
                largest = np.max(np.abs(statics.loose[:, :, :, position]), axis=(0, 1), initial=0.0)
                unknown |= np.any(carried > 1e-9 * np.where(largest > 0, largest, 1.0), axis=(1, 2))
    return unknown
