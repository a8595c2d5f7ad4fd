"""Velocities and accelerations of all bodies for given rates of the prescribed coordinates, with closed loops.

Accelerations are the sum of a part that is linear in the accelerations of the coordinates and a part that is quadratic in their
velocities. The second part is the derivative of the velocities along a straight line of the coordinates, computed by central
differences of eighth order.
"""

from __future__ import annotations

import numpy as np

from kinetostatics.arguments import finite_numbers
from kinetostatics.description.loads import Motion
from kinetostatics.exceptions import ArgumentError
from kinetostatics.kinematics.assembly import platform_coordinates
from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.kinematics.coordinates import PrescribedCoordinates
from kinetostatics.kinematics.path_following import follow
from kinetostatics.kinematics.solver import Solver, SolverState
from kinetostatics.kinematics.velocities import twists_of_bodies, velocities_of
from kinetostatics.math.arrays import Array
from kinetostatics.math.screws import move_twist, wrench_of_couple, wrench_of_force

#: Largest motion of a freedom in the differences [rad, characteristic lengths], and the weights of the differences.
_STEP = 5e-3
_WEIGHTS = {1: 4 / 5, 2: -1 / 5, 3: 4 / 105, 4: -1 / 280}


def prescribed_motion(configuration: Configuration, motion: Motion) -> tuple[PrescribedCoordinates, Array, Array]:
    """Return the coordinates of a motion, their velocities (n, …) [m/s, rad/s] and accelerations (n, …) [m/s², rad/s²].

    Raises:
        ArgumentError: a rate is not a number, or the shapes cannot be broadcast.
        CoordinatesError: the coordinates are unknown, or do not determine the pose.
    """
    robot, rates = configuration.robot, (motion.velocities, motion.accelerations)
    given = dict.fromkeys(name for by_name in rates for name in by_name)
    if set(given) <= set(robot.description.actuated):
        prescribed, names = robot.actuator_coordinates, robot.actuator_names
    else:
        chosen = configuration.prescribed if set(given) <= set(configuration.prescribed) else given
        prescribed, names = platform_coordinates(robot, dict.fromkeys(chosen, 0.0), configuration.orientation.name)
    numbers = [[finite_numbers(f"the rate of {name}", by_name.get(name, 0.0)) for name in names] for by_name in rates]
    try:
        shape = np.broadcast_shapes(configuration.shape, *(array.shape for row in numbers for array in row))
    except ValueError:
        raise ArgumentError(f"the motion's rates do not fit the poses, whose batch shape is {configuration.shape}") from None
    velocity, acceleration = (np.array([np.broadcast_to(array, shape) for array in row]).reshape(-1, *shape) for row in numbers)
    return robot.mobility_analysis.with_dofs(prescribed), velocity, acceleration


def moving_bodies(
    solver: Solver, prescribed: PrescribedCoordinates, poses: SolverState, velocity: Array, acceleration: Array
) -> tuple[Array, Array, Array]:
    """Return the motion of all B bodies at N closed poses, with local freedoms at rest.

    With twists t = J(q) q̇, their derivative is J q̈ + J̇ q̇, J̇ by central differences of eighth order along the motion.

    Args:
        velocity: (n, N) velocities of the coordinates [m/s, rad/s].
        acceleration: (n, N) accelerations of the coordinates [m/s², rad/s²].

    Returns:
        The twists (6, B, N) of the bodies at the world's origin, world axes [m/s, rad/s]; their time derivatives; and unit
        motions (6, B, k, N) of the bodies in the local freedoms, which change neither loops nor prescribed coordinates.
    """
    target = solver.values(prescribed, poses)
    rates = velocities_of(solver, prescribed, poses, target, np.stack([velocity, acceleration], axis=1))
    linear = twists_of_bodies(solver, poses, rates)
    twists, derivative = linear[:, :, 0], np.array(linear[:, :, 1])
    scale = np.where(solver.tree.column_rotates, 1.0, 1 / solver.length)[:, None]
    fastest = np.max(np.abs(rates[:, 0]) * scale, axis=0, initial=0.0)
    moves = fastest > 0
    step = _STEP / np.where(moves, fastest, 1.0) / max(_WEIGHTS)
    for k, weight in _WEIGHTS.items():
        for side in (1, -1):
            there = target + side * k * step * velocity
            near, _, _ = follow(solver, prescribed, poses, there)
            shifted = twists_of_bodies(solver, near, velocities_of(solver, prescribed, near, there, velocity[:, None]))
            derivative += np.where(moves, side * weight / step * shifted[:, :, 0], 0.0)
    return twists, derivative, _local(solver, prescribed, poses, target)


def actuator_rates(configuration: Configuration, motion: Motion) -> tuple[dict[str, Array], Array]:
    """Return the velocity (…) of every actuator and the platform's twist (…, 6) at o [m/s, rad/s] in a motion, loops closed.

    Raises:
        ArgumentError, CoordinatesError: as :func:`prescribed_motion`.
    """
    robot, poses = configuration.robot, configuration.poses
    prescribed, velocity, _ = prescribed_motion(configuration, motion)
    target = robot.solver.values(prescribed, poses)
    rates = velocities_of(robot.solver, prescribed, poses, target, velocity.reshape(len(velocity), 1, -1))
    twists = twists_of_bodies(robot.solver, poses, rates)[:, :, 0]
    speeds, frames = {}, robot.equations.forward(poses.x)
    for name in robot.description.actuated:
        joint = robot.mechanism.connections[name]
        axis = frames.direction(joint.predecessor_body, joint.axis_on(True))
        point = frames.point(joint.successor_body, joint.successor_frame[:3, 3])
        wrench = wrench_of_force(axis, point) if joint.type.is_slide else wrench_of_couple(axis)
        relative = twists[:, joint.successor_body] - twists[:, joint.predecessor_body]
        speeds[name] = np.einsum("in,in->n", wrench, relative).reshape(velocity.shape[1:])
    twist = move_twist(twists[:, robot.mechanism.platform_frame[0]], robot.mechanism.platform_pose(frames)[1])
    return speeds, twist.T.reshape(*velocity.shape[1:], 6)


def _local(solver: Solver, prescribed: PrescribedCoordinates, poses: SolverState, target: Array) -> Array:
    """Return the unit motions (6, B, k, N) of all bodies in local freedoms, such as the spin of a strut between ball joints."""
    idle, k = list(prescribed.fixed_dofs), prescribed.local_dofs
    v = np.zeros((solver.tree.nv, len(idle) + k, poses.x.shape[1]))
    v[idle, range(len(idle))] = solver.column_scale[idle, None]
    if k:
        gradient, _ = solver.rates(prescribed, poses, target)
        axes = np.linalg.svd(np.nan_to_num(np.moveaxis(gradient, 2, 0)))[2][:, -k:]
        free = solver.free_columns(prescribed)
        v[free, len(idle) :] = axes[:, :, : free.size].transpose(2, 1, 0) * solver.column_scale[free, None, None]
    return twists_of_bodies(solver, poses, v)
