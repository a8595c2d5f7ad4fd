"""In which directions no drive moves the platform, at given poses: what a correction of the drives must leave."""

from __future__ import annotations

import numpy as np

from kinetostatics.kinematics.configuration import Configuration
from kinetostatics.math.arrays import Array
from kinetostatics.math.linalg import cross
from kinetostatics.robot import robot_of

#: Axes that tell a pose's directions this little, as cosines, are chosen anew.
ASKEW = 0.1


def uncorrectable_directions(configuration: Configuration, tool: Array | None) -> Array:
    """Return the twists (6, k, N) [m, rad] of :attr:`Compensation.uncorrectable_directions`; NaN where there is no pose.

    The twists that the loops leave the platform, its drives free, are moved to the reference point, displacements scaled by the
    characteristic length, and what is orthogonal to them is found. Of all its orthonormal bases that one is taken that is nearest
    to coordinate axes, the same ones along a batch.
    """
    robot = robot_of(configuration)
    k, length = 6 - robot.mobility.platform, robot.length
    R, _ = robot.mechanism.platform_pose(configuration.frames)
    found = np.full((6, k, R.shape[2]), np.nan)
    axes: list[int] = []
    for n in np.flatnonzero(configuration.reached):
        moves = robot.mobility_analysis.platform_motions(configuration.poses.take(np.array([n])))
        if moves.shape[1] != 6 - k:
            continue  # a pose at which the platform has another mobility
        if tool is not None:
            arm = R[:, :, n] @ tool / length
            moves = np.concatenate([moves[:3] + cross(moves[3:], np.broadcast_to(arm[:, None], moves[3:].shape)), moves[3:]])
        rest = np.linalg.svd(moves)[0][:, 6 - k :]
        if not axes or np.linalg.svd(rest[axes], compute_uv=False).min(initial=1.0) < ASKEW:
            axes = _nearest_axes(rest)
        U, _, V = np.linalg.svd(rest[axes].T)
        found[:, :, n] = rest @ U @ V
    found[:3] *= length
    return found


def _nearest_axes(basis: Array) -> list[int]:
    """Return the coordinate axes that are told best by a basis (6, k): each the longest beside those before it."""
    left, axes = np.array(basis), []
    for _ in range(basis.shape[1]):
        sizes = np.linalg.norm(left, axis=1)
        axes.append(int(np.argmax(sizes > sizes.max() - 1e-6)))  # of nearly equal ones the first
        along = left[axes[-1]] / sizes[axes[-1]]
        left = left - np.outer(left @ along, along)
    return sorted(axes)
