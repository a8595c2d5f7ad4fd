"""Twists that the actuators cannot produce: pose errors that no correction removes."""

from __future__ import annotations

import numpy as np

from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.math.arrays import Array, chunks
from kinetostatics.math.screws import move_twist
from kinetostatics.robot import robot_of

#: Smallest singular value of the projection on the chosen coordinate axes; below it, other axes are chosen for a pose.
ASKEW = 0.1


def uncorrectable_directions(configuration: Configuration, tool: Array | None) -> Array:
    """Return the twists (6, k, N) [m, rad] of :attr:`Compensation.uncorrectable_directions`; NaN where no pose was found.

    The free twists of the platform, with unlocked actuators, are moved to the reference point, with displacements divided by the
    characteristic length; the result spans their orthogonal complement. Of its orthonormal bases, the one nearest to coordinate
    axes is chosen, with the same axes along a batch.
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
    """Return the k coordinate axes nearest to the span of a basis (6, k), by Gram-Schmidt elimination with pivoting."""
    left, axes = np.array(basis), []
    for _ in range(basis.shape[1]):
        sizes = np.linalg.norm(left, axis=1)
        axes.append(int(np.argmax(sizes > sizes.max() - 1e-6)))  # of nearly equal ones, the first
        along = left[axes[-1]] / sizes[axes[-1]]
        left = left - np.outer(left @ along, along)
    return sorted(axes)
