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

#: Order of preference of coordinates.
PREFERRED = ("z", "x", "y", "rz", "rx", "ry", "azimuth", "tilt", "torsion")
#: Number of sets in a message.
NAMED = 3
#: Factor by which the measure of a set must exceed that of earlier ones.
MARGIN = 1.5


@lru_cache(maxsize=256)
def prescribed_platform(names: tuple[str, ...], orientation: Orientation) -> PrescribedCoordinates:
    """Return the prescribed coordinates of the platform for the solver."""
    positions = tuple(k for k, name in enumerate("xyz") if name in names)
    angles = tuple(k for k, name in enumerate(orientation.names) if name in names)
    return PrescribedCoordinates(positions=positions, angles=angles, orientation=orientation)


def choices(robot: RobotKinematics, orientation: Orientation, given: Sequence[str], pose: SolverState) -> list[tuple[str, ...]]:
    """Return the sets of coordinates, as many as the mobility, that determine the pose, also at ``pose`` if possible.

    They are ordered by their difference from ``given``, then in the order z, x, y, rz, rx, ry.
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
    """Return the set of coordinates with the largest measure at one pose; of nearly equal measures, the first set.

    The measure is the smallest singular value of the map from the platform's motions, with translations relative to the
    characteristic length, to the rates of the coordinates. The result is empty if no coordinates determine the pose.
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
    """Return the sets of coordinates that determine the pose, also at ``pose`` if possible, as text."""
    found = [", ".join(names) for names in choices(robot, orientation, given, pose)]
    if not found:
        return f"no coordinates with the orientation {orientation.name!r} do"
    verb = "does" if robot.mobility.platform == 1 else "do"
    return f"{' or '.join(found[:NAMED])} {verb}{', for example' * (len(found) > NAMED)}"
