"""Which coordinates of the platform determine the pose, where those that were given do not."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

from kinetostatics.kinematics.robot_kinematics import RobotKinematics
from kinetostatics.kinematics.solver import PrescribedCoordinates, SolverState
from kinetostatics.math.orientation import Orientation

#: The order in which sets of coordinates are named.
PREFERRED = ("z", "x", "y", "rz", "rx", "ry", "azimuth", "tilt", "torsion")
#: Sets that a message names.
NAMED = 3


def prescribed_platform(names: Sequence[str], orientation: Orientation) -> PrescribedCoordinates:
    """Return coordinates of the platform as the solver sees them."""
    positions = tuple(k for k, name in enumerate("xyz") if name in names)
    angles = tuple(k for k, name in enumerate(orientation.names) if name in names)
    return PrescribedCoordinates(positions=positions, angles=angles, orientation=orientation)


def choices(robot: RobotKinematics, orientation: Orientation, given: Sequence[str], pose: SolverState) -> list[tuple[str, ...]]:
    """Return the sets of coordinates that determine the pose, at ``pose`` too if any do; as many in each as the mobility.

    Those that differ least from ``given`` come first, then those in the order z, x, y, rz, rx, ry.
    """
    known = [name for name in PREFERRED if name in ("x", "y", "z", *orientation.names)]
    sets = [
        names
        for names in combinations(known, robot.mobility.platform)
        if robot.mobility_analysis.fixes_platform(prescribed_platform(names, orientation))
    ]
    here = [names for names in sets if robot.mobility_analysis.fixes_platform_at(prescribed_platform(names, orientation), pose)]
    return sorted(here or sets, key=lambda names: sum(name not in given for name in names))


def say_choices(robot: RobotKinematics, orientation: Orientation, given: Sequence[str], pose: SolverState) -> str:
    """Say which coordinates determine the pose, at ``pose`` too if any do."""
    found = [", ".join(names) for names in choices(robot, orientation, given, pose)]
    if not found:
        return f"no coordinates with the orientation {orientation.name!r} do"
    verb = "does" if robot.mobility.platform == 1 else "do"
    return f"{' or '.join(found[:NAMED])} {verb}{', for example' * (len(found) > NAMED)}"
