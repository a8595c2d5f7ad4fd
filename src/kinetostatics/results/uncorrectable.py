"""Directions in which no actuator moves the platform: pose errors that no correction removes."""

from __future__ import annotations

import numpy as np

from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.math.arrays import Array, chunks
from kinetostatics.math.screws import move_twist
from kinetostatics.robot import robot_of

#: Axes that tell a pose's directions this little, as cosines, are chosen anew.
ASKEW = 0.1


def uncorrectable_directions(configuration: Configuration, tool: Array | None) -> Array:
    """Return the twists (6, k, N) [m, rad] of :attr:`Compensation.uncorrectable_directions`; NaN where there is no pose.

    The twists that the loops leave the platform, its actuators free, are moved to the reference point, displacements scaled by
    the characteristic length, and what is orthogonal to them is found. Of all its orthonormal bases that one is taken that is
    nearest to coordinate axes, the same ones along a batch.
    """
    robot = robot_of(configuration)
    n, length = robot.mobility.platform, robot.length
    R, _ = robot.mechanism.platform_pose(configuration.frames)
    found = np.full((R.shape[2], 6, 6 - n), np.nan)
    reached = np.flatnonzero(configuration.reached)
    for part in chunks(reached.size):
        which = reached[part]
        moves = robot.mobility_analysis.motions_at(configuration.poses.take(which))
        if tool is not None:
            arms = np.einsum("ijn,j->in", R[:, :, which], tool / length)
            moves = np.moveaxis(move_twist(np.moveaxis(moves, 0, 2), arms), 2, 0)
        regular = np.all(np.isfinite(moves), axis=(1, 2))
        found[which[regular]] = np.linalg.svd(moves[regular])[0][:, :, n:]
    left = np.flatnonzero(np.all(np.isfinite(found), axis=(1, 2)))
    while n < 6 and left.size:
        axes = _nearest_axes(found[left[0]])
        U, sizes, V = np.linalg.svd(np.swapaxes(found[left][:, axes], 1, 2))
        distinct = (sizes[:, -1] >= ASKEW) | (np.arange(left.size) == 0)
        found[left[distinct]] = (found[left] @ U @ V)[distinct]
        left = left[~distinct]
    found[:, :3] *= length
    return np.moveaxis(found, 0, 2)


def _nearest_axes(basis: Array) -> list[int]:
    """Return the k coordinate axes nearest to the span of a basis (6, k): each the longest beside those before it."""
    left, axes = np.array(basis), []
    for _ in range(basis.shape[1]):
        sizes = np.linalg.norm(left, axis=1)
        axes.append(int(np.argmax(sizes > sizes.max() - 1e-6)))  # of nearly equal ones the first
        along = left[axes[-1]] / sizes[axes[-1]]
        left = left - np.outer(left @ along, along)
    return sorted(axes)
