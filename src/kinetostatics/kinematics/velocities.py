"""How fast freedoms, bodies and actuators move with what is given, loops staying closed, by the implicit function theorem."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from kinetostatics.kinematics.prescribed import PrescribedCoordinates
from kinetostatics.kinematics.solver import Solver, SolverState
from kinetostatics.math.arrays import Array, zeros_for
from kinetostatics.math.linalg import cross
from kinetostatics.math.screws import move_twist
from kinetostatics.mechanism.tree import Frames

#: Part of a change that the loops cannot follow above which they stay open.
_OPEN = 1e-6


def freedom_rates(solver: Solver, prescribed: PrescribedCoordinates, gradient: Array, rates: Array, step: Array) -> Array:
    """Return how fast the freedoms move (nv, k, N) that are not given; NaN where residuals do not stay zero.

    Args:
        solver: of the loops.
        prescribed: what is given.
        gradient: (m, n, N) of the scaled residuals by scaled steps of what is free.
        rates: (m, k, N) how fast the residuals change by themselves.
        step: (n, k, N) the steps that undo that as well as possible.
    """
    left = np.max(np.abs(rates + np.einsum("mnN,nkN->mkN", gradient, step)), axis=0, initial=0.0)
    stays_open = left > _OPEN * np.max(np.abs(rates), axis=0, initial=0.0) + 1e-12
    free = solver.free_columns(prescribed)
    v = zeros_for((solver.tree.nv, *step.shape[1:]), step)
    v[free] = step[: free.size] * solver.column_scale[free, None, None]
    return np.where(stays_open, np.nan, v)


def with_given(solver: Solver, prescribed: PrescribedCoordinates, v: Array) -> Array:
    """Return the rates (nv, n, N) by each given coordinate, those of the freedoms that are given and of their followers too."""
    found = np.array(v, subok=True)
    for k, column in enumerate(prescribed.columns):
        for moved, by in solver.equations.couplings.moving_with(column):
            found[moved, k] += by
    return found


def frame_rates(moves: Array, twists: Array, frames: Frames, v: Array) -> tuple[Array, Array]:
    """Return how fast bodies' rotations (3, 3, B, N) and positions (3, B, N) change.

    Args:
        moves: (B, nv) how each freedom moves each body.
        twists: (6, nv, N) of the freedoms, about the world's origin.
        frames: of the bodies.
        v: (nv, N) the freedoms' rates.
    """
    twist = np.einsum("bk,ikn,kn->ibn", moves, twists, v, optimize=True)
    rotation = np.stack([cross(twist[3:], frames.rotation[:, j]) for j in range(3)], axis=1)
    return rotation, move_twist(twist, frames.position)[:3]


def actuator_rates(solver: Solver, given: PrescribedCoordinates, poses: SolverState, v: Array) -> Array:
    """Return the rates (actuators, k, N) of actuators' coordinates, in the order of ``given``, at freedoms' rates (nv, k, N)."""
    rows: list[Array] = [v[column] for column in given.columns]
    if given.loops:
        loops = replace(given, columns=())
        _, gradient = solver.system(loops, poses, np.zeros((len(given.loops), poses.x.shape[1])))
        for row, number in zip(gradient[solver.equations.count :], given.loops, strict=True):
            unit = solver.length if solver.equations.loops[number].type.is_slide else 1.0
            rows.append(np.einsum("vn,vkn->kn", row * (unit / solver.column_scale)[:, None], v))
    return np.stack(rows) if rows else zeros_for((0, *v.shape[1:]), v)


def body_moves(solver: Solver) -> Array:
    """Return (B, nv) how each freedom moves each body, as seen from the base.

    Bodies inside a spherical joint count with the body that the joint hangs on.
    """
    moves = solver.equations.tree.moves.astype(float)
    for run in solver.mechanism.spherical_runs:
        moves[list(run.bodies[:2])] = moves[run.parent]
    base = solver.mechanism.base_frame
    return moves if base is None else moves - moves[base[0]]
