"""Sets of platform coordinates that determine the pose."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from itertools import combinations

import numpy as np

from kinetostatics.kinematics.prescribed import PrescribedCoordinates
from kinetostatics.kinematics.robot_kinematics import RobotKinematics
from kinetostatics.kinematics.solver import SolverState
from kinetostatics.math.orientation import Orientation

#: The order in which sets of coordinates are named.
PREFERRED = ("z", "x", "y", "rz", "rx", "ry", "azimuth", "tilt", "torsion")
#: Sets that a message names.
NAMED = 3
#: By what factor a set must tell more than one before it, to be better.
MARGIN = 1.5


@lru_cache(maxsize=256)
def prescribed_platform(names: tuple[str, ...], orientation: Orientation) -> PrescribedCoordinates:
    """Return coordinates of the platform as the solver sees them."""
    positions = tuple(k for k, name in enumerate("xyz") if name in names)
    angles = tuple(k for k, name in enumerate(orientation.names) if name in names)
    return PrescribedCoordinates(positions=positions, angles=angles, orientation=orientation)


def choices(robot: RobotKinematics, orientation: Orientation, given: Sequence[str], pose: SolverState) -> list[tuple[str, ...]]:
    """Return the sets of coordinates that determine the pose, at ``pose`` too if any do; as many in each as the mobility.

    Those that differ least from ``given`` come first, then those in the order z, x, y, rz, rx, ry.
    """
    known = [name for name in PREFERRED if name in orientation.pose_names]
    sets = [
        names
        for names in combinations(known, robot.mobility.platform)
        if robot.mobility_analysis.fixes_platform(prescribed_platform(names, orientation))
    ]
    here = [names for names in sets if robot.mobility_analysis.fixes_platform_at(prescribed_platform(names, orientation), pose)]
    return sorted(here or sets, key=lambda names: sum(name not in given for name in names))


def best_choice(robot: RobotKinematics, orientation: Orientation, pose: SolverState) -> tuple[str, ...]:
    """Return the coordinates that tell the platform's motions at one pose best, of nearly equal sets the first.

    The measure is the smallest singular value of the map from the platform's motions, in lengths, to the coordinates. Nothing is
    returned where no coordinates determine the pose.
    """
    R, _ = robot.mechanism.platform_pose(robot.equations.forward(pose.x))
    rates = orientation.rates(orientation.coordinates(R))[:, :, 0]
    motions = robot.mobility_analysis.platform_motions(pose)
    rows = np.concatenate([motions[:3], np.linalg.pinv(rates) @ motions[3:]])
    known = orientation.pose_names
    found: tuple[str, ...] = ()
    most = 0.0
    for names in choices(robot, orientation, (), pose):
        values = np.linalg.svd(rows[[known.index(name) for name in names]], compute_uv=False)
        if (least := float(values.min(initial=1.0))) > MARGIN * most:
            found, most = names, least
    return found


def choices_text(robot: RobotKinematics, orientation: Orientation, given: Sequence[str], pose: SolverState) -> str:
    """Return the sets of coordinates that determine the pose, at ``pose`` too if any do, as text."""
    found = [", ".join(names) for names in choices(robot, orientation, given, pose)]
    if not found:
        return f"no coordinates with the orientation {orientation.name!r} do"
    verb = "does" if robot.mobility.platform == 1 else "do"
    return f"{' or '.join(found[:NAMED])} {verb}{', for example' * (len(found) > NAMED)}"
