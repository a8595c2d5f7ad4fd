"""Velocities of freedoms, bodies and platform at closed poses, from the gradients of the loop equations (implicit functions)."""

from __future__ import annotations

import numpy as np

from kinetostatics.kinematics.coordinates import PrescribedCoordinates
from kinetostatics.kinematics.robot_kinematics import RobotKinematics
from kinetostatics.kinematics.solver import Solver, SolverState
from kinetostatics.math.arrays import Array, zeros_for
from kinetostatics.math.linalg import least_squares

#: Relative residual of the rates above which the loops cannot remain closed.
_OPEN = 1e-6


def freedom_rates(solver: Solver, prescribed: PrescribedCoordinates, gradient: Array, rates: Array, step: Array) -> Array:
    """Return the rates (nv, k, N) of the unknown freedoms; NaN where the residuals cannot remain zero.

    The scaled residuals change at ``rates`` (m, k, N) if the unknowns are fixed, and by ``gradient`` (m, f, N) per scaled step of
    each of f unknowns. The ``step`` (f, k, N) of the unknowns compensates the rates in the least-squares sense.
    """
    left = np.max(np.abs(rates + np.einsum("mnN,nkN->mkN", gradient, step)), axis=0, initial=0.0)
    stays_open = left > _OPEN * np.max(np.abs(rates), axis=0, initial=0.0) + 1e-12
    free = solver.free_columns(prescribed)
    v = zeros_for((solver.tree.nv, *step.shape[1:]), step)
    v[free] = step[: free.size] * solver.column_scale[free, None, None]
    return np.where(stays_open, np.nan, v)


def with_given(solver: Solver, prescribed: PrescribedCoordinates, v: Array) -> Array:
    """Return the rates (nv, n, N) of all freedoms per unit rate of each prescribed coordinate.

    ``v`` (nv, n, N) are the rates of the unknown freedoms alone; prescribed freedoms and their followers are added.
    """
    rates = np.array(v, subok=True)
    for k, column in enumerate(prescribed.columns):
        for moved, by in solver.equations.couplings.rates_with(column):
            rates[moved, k] += by
    return rates


def velocities_of(solver: Solver, prescribed: PrescribedCoordinates, poses: SolverState, target: Array, rates: Array) -> Array:
    """Return the velocities v (nv, k, N) of all freedoms at rates ċ (n, k, N) of the prescribed coordinates: A v = −B ċ."""
    gradient, changes = solver.rates(prescribed, poses, target)
    step = -least_squares(gradient, changes, prescribed.local_dofs)
    left = changes + np.einsum("mnN,nkN->mkN", gradient, step)
    step = step - least_squares(gradient, left, prescribed.local_dofs)  # near a singular pose the first step is inexact
    v = with_given(solver, prescribed, freedom_rates(solver, prescribed, gradient, changes, step))
    return np.asarray(np.einsum("vnN,nkN->vkN", v, rates))


def twists_of_bodies(solver: Solver, poses: SolverState, v: Array) -> Array:
    """Return the twists Σ S_j v_j (6, B, k, N) of all bodies about the world's origin at velocities v (nv, k, N)."""
    unit, moves = solver.tree.twists(solver.equations.forward(poses.x)), solver.tree.moves.astype(float)
    return np.asarray(np.einsum("ivN,vkN,bv->ibkN", unit, v, moves))


def platform_jacobian(robot: RobotKinematics, poses: SolverState) -> Array:
    """Return the twists (6, a, N) of the platform at o per unit speed of each actuated joint, in the order of the file."""
    prescribed = robot.mobility_analysis.with_dofs(robot.actuator_coordinates)
    unit = np.repeat(np.eye(len(robot.actuator_names))[:, :, None], poses.x.shape[1], axis=2)
    v = velocities_of(robot.solver, prescribed, poses, robot.solver.values(prescribed, poses), unit)
    body = robot.mechanism.platform_frame[0]
    twists = twists_of_bodies(robot.solver, poses, v)[:, body]
    o = robot.mechanism.platform_pose(robot.equations.forward(poses.x))[1]
    twists[:3] += np.cross(twists[3:], o[:, None], axis=0)
    return twists[:, [robot.actuator_names.index(name) for name in robot.description.actuated]]
